//! Whether sensors read all that the machine can do.              reference: docs/reference/machine-file.md

use crate::crane::limits::in_words;
use crate::crane::Crane;
use hydrocrane_machine::model::{Sensor, Unusual};

/// Nobody gives away more than four bits of a sensor: kN were meant as MN, or cm as m.
const WIDE: f64 = 20.0;

impl<const N: usize> Crane<N> {
    /// Sensors whose range leaves out a part of what they measure, or is far wider: joint coordinates and piston positions between their limits, pressures
    /// up to that of the supply, and the force that a cylinder holds at rest in the middle of all joint ranges.
    pub(crate) fn short_ranges(&self) -> Vec<Unusual> {
        self.machine.sensors.iter().filter_map(|sensor| self.short_range(sensor)).collect()
    }

    fn short_range(&self, sensor: &Sensor) -> Option<Unusual> {
        let (machine, [low, high]) = (&self.machine, sensor.limits()?);
        let mut parts = sensor.measures.split('.');
        let (of, name, signal) = (parts.next()?, parts.next()?, parts.next()?);
        let index = match of {
            "joint" => machine.joints.iter().position(|joint| joint.name == name)?,
            _ => machine.cylinders.iter().position(|cylinder| cylinder.name == name)?,
        };
        let plant = self.plant();
        let stop = &plant.cylinders[index].end_stop;
        let ([least, most], words): ([f64; 2], &dyn Fn(f64) -> String) = match signal {
            "q" => ([self.limits[index].lower, self.limits[index].upper], &|q| in_words(&machine.joints[index], q)),
            "x" => ([stop.lower, stop.upper], &|x| format!("{:.1} mm", 1e3 * x)),
            "force" => {
                let q = hydrocrane_num::array::from_fn(|i| 0.5 * (self.limits[i].lower + self.limits[i].upper));
                let held = plant.static_force(&q, machine.payload.mass)[index];
                ([held.min(0.0), held.max(0.0)], &|f| format!("{:.3} kN", 1e-3 * f))
            }
            "p1" | "p2" => ([0.0, machine.supply.rated], &|p| format!("{:.0} bar", 1e-5 * p)),
            _ => return None,
        };
        let rounding = 1e-6 * (most - least);
        // What a cylinder holds in one pose says little of what it can press.
        let largest = match signal {
            "force" => machine.supply.rated * plant.cylinders[index].chambers.area_1,
            _ => most - least,
        };
        if high - low > WIDE * largest.max(most - least) && largest > 0.0 {
            return Some(Unusual {
                key: sensor.key.clone(),
                place: sensor.place.to_string(),
                text: format!(
                    "wide: the sensor reads {} to {}, but `{}` has {} in all",
                    words(low),
                    words(high),
                    sensor.measures,
                    words(largest)
                ),
                cure: "check its unit, and that of what it measures".to_string(),
            });
        }
        (least < low - rounding || most > high + rounding).then(|| Unusual {
            key: sensor.key.clone(),
            place: sensor.place.to_string(),
            text: format!(
                "short: the sensor reads {} to {}, but `{}` has {} to {}",
                words(low),
                words(high),
                sensor.measures,
                words(least),
                words(most)
            ),
            cure: match signal {
                "q" | "x" if most - least <= high - low => {
                    format!("state its `offset`: {} in the middle of its range", words(0.5 * (least + most)))
                }
                _ => format!("take a sensor with a range of {} at least", words(most - least)),
            },
        })
    }
}
