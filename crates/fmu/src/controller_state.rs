//! The changing state of a controller. A copy of it is as large as the controller; its bytes are all samples since the start,
//! from which another instance computes the same controller again.

use crate::fault::{sound, Fault};
use crate::history::History;
use hydrocrane_sim::controller::Controller;
use hydrocrane_sim::Archive;

pub struct ControllerState {
    pub inputs: Inputs,
    /// m
    pub command: Vec<f64>,
    pub going: Option<Going>,
    pub history: History,
}

/// What a tool sets, and the time.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Identifier of the FMU.
    pub token: String,
    pub parameters: Vec<f64>,
    pub readings: Vec<f64>,
    pub sticks: Vec<f64>,
    pub began: f64,
    /// Since the beginning, s.
    pub time: f64,
}

/// A running controller.
pub struct Going {
    pub controller: Box<dyn Controller>,
    /// Number of samples so far.
    pub samples: u64,
    pub fault: Option<String>,
}

impl Going {
    pub fn copied(&self) -> Result<Self, Fault> {
        let controller = self.controller.copied();
        let controller = controller.ok_or_else(|| Fault::from("this controller cannot be copied".to_string()))?;
        Ok(Going { controller, samples: self.samples, fault: self.fault.clone() })
    }
}

impl Inputs {
    /// Numbers of a sample: its time, readings and sticks.
    pub fn width(&self) -> usize {
        1 + self.readings.len() + self.sticks.len()
    }

    /// Visits all values, for writing or reading.
    fn archive(&mut self, archive: &mut Archive) {
        for part in self.token.as_bytes().chunks(8) {
            let mut bytes = [0; 8];
            bytes[..part.len()].copy_from_slice(part);
            let own = u64::from_le_bytes(bytes);
            let mut found = own;
            archive.whole(&mut found);
            if found != own {
                archive.spoil();
            }
        }
        for values in [&mut self.parameters, &mut self.readings, &mut self.sticks] {
            archive.numbers(values);
        }
        archive.number(&mut self.began);
        archive.number(&mut self.time);
    }

    /// The inputs and samples in the bytes of a state, for a controller with inputs like these.
    ///
    /// # Errors
    /// Bytes of another FMU, or damaged ones.
    pub fn read(&self, bytes: &[u8]) -> Result<(Self, Vec<Vec<f64>>), Fault> {
        let (mut inputs, mut archive, mut count) = (self.clone(), Archive::reading(bytes), 0);
        inputs.archive(&mut archive);
        archive.whole(&mut count);
        // More samples than there are bytes for are damage.
        let room = bytes.len() / (size_of::<f64>() * self.width());
        let mut samples = vec![vec![0.0; self.width()]; (count as usize).min(room)];
        samples.iter_mut().for_each(|sample| archive.numbers(sample));
        if samples.len() as u64 != count {
            archive.spoil();
        }
        sound(&archive).map(|()| (inputs, samples))
    }
}

impl ControllerState {
    /// What stands before the samples, and their number.
    fn head(&self) -> Result<(Archive<'_>, usize), Fault> {
        if !self.history.is_whole() {
            return Err(TOO_LONG.to_string().into());
        }
        let (mut inputs, mut archive, count) =
            (self.inputs.clone(), Archive::writing(), self.history.samples().count());
        inputs.archive(&mut archive);
        archive.whole(&mut (count as u64));
        Ok((archive, count))
    }

    /// Number of [`Self::bytes`], without making them.
    ///
    /// # Errors
    /// As there.
    pub fn length(&self) -> Result<usize, Fault> {
        let (head, count) = self.head()?;
        Ok(head.into_bytes().len() + size_of::<f64>() * self.inputs.width() * count)
    }

    /// # Errors
    /// After too many samples.
    pub fn bytes(&self) -> Result<Vec<u8>, Fault> {
        let (mut archive, _) = self.head()?;
        for sample in self.history.samples() {
            archive.numbers(&mut sample.to_vec());
        }
        Ok(archive.into_bytes())
    }
}

const TOO_LONG: &str =
    "the bytes of a controller's state hold all its samples, and there have been more than 64 MiB; keep the \
                        state without turning it into bytes, or reset the FMU";

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs() -> Inputs {
        let (token, readings) = ("{0123-4567}".to_string(), vec![f64::NAN, -0.0]);
        Inputs { token, parameters: vec![4.0], readings, sticks: vec![0.1, 0.2], began: 1.0, time: 0.25 }
    }

    fn state() -> ControllerState {
        let mut history = History::new(inputs().width());
        (0..3).for_each(|k| history.push([0.1 * f64::from(k), 1.0, 2.0, 0.0, 0.0].into_iter()));
        ControllerState { inputs: inputs(), command: vec![0.0], going: None, history }
    }

    fn bytes() -> Vec<u8> {
        state().bytes().expect("few samples")
    }

    #[test]
    fn the_number_of_bytes_is_known_without_them() {
        assert_eq!(state().length().expect("few samples"), bytes().len());
    }

    #[test]
    fn bytes_are_read_back_with_all_samples() {
        let other = Inputs { parameters: vec![0.0], readings: vec![0.0; 2], sticks: vec![0.0; 2], ..inputs() };
        let (found, samples) = other.read(&bytes()).expect("sound");
        assert_eq!(format!("{found:?}"), format!("{:?}", inputs()));
        assert_eq!((samples.len(), samples[2][0]), (3, 0.2));
    }

    #[test]
    fn damage_and_the_state_of_another_fmu_are_refused() {
        let bytes = bytes();
        let longer = [&bytes[..], &[0; 8]].concat();
        let mut many = bytes.clone();
        let count = bytes.len() - 3 * 5 * 8 - 8;
        many[count..count + 8].fill(0xff);
        for damaged in [&bytes[..bytes.len() - 1], &longer, &many, &[]] {
            assert!(inputs().read(damaged).is_err());
        }
        assert!(Inputs { token: "{0123-4568}".to_string(), ..inputs() }.read(&bytes).is_err());
    }
}
