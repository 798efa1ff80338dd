//! A controller behind the monitor of its sensors, where there is a heap.  theory: docs/theory/control/plausibility.md

use crate::estimate::valve_learning::LearntValve;
use crate::interface::controller::{Alarm, Controller, Fault, Measurement, Report, Stick};
use crate::interface::notice::Names;
use crate::model::controller_model::ControllerModel;
use crate::monitor::plausibility::Monitor;
use crate::monitor::safe_state::{Guarded, SafeState, SensorNotice};

pub struct Monitored<const N: usize> {
    known: Known<N>,
    safe_state: SafeState<N>,
    names: Names,
}

struct Known<const N: usize> {
    controller: Box<dyn Controller>,
    model: ControllerModel<N>,
}

impl<const N: usize> Guarded<N> for Known<N> {
    type Controller = dyn Controller;

    fn controller(&mut self) -> &mut Self::Controller {
        self.controller.as_mut()
    }

    fn model(&self) -> &ControllerModel<N> {
        &self.model
    }
}

impl<const N: usize> Monitored<N> {
    /// `controller` behind the `monitor` of a crane with this `model`.
    pub fn new(controller: Box<dyn Controller>, model: ControllerModel<N>, monitor: Monitor<N>, names: Names) -> Self {
        Monitored { known: Known { controller, model }, safe_state: SafeState::new(monitor), names }
    }
}

impl<const N: usize> Controller for Monitored<N> {
    fn period(&self) -> f64 {
        self.known.controller.period()
    }

    fn copied(&self) -> Option<Box<dyn Controller>> {
        let known = Known { controller: self.known.controller.copied()?, model: self.known.model };
        Some(Box::new(Monitored { known, safe_state: self.safe_state.clone(), names: self.names.clone() }))
    }

    fn reset(&mut self, first: &Measurement) {
        self.safe_state.reset(&mut self.known, first);
    }

    fn step(&mut self, measured: &Measurement, stick: Stick, spool: &mut [f64]) -> Result<(), Fault> {
        self.safe_state.step(&mut self.known, measured, stick, spool)
    }

    fn reads_pressures(&self) -> bool {
        self.known.controller.reads_pressures()
    }

    fn refuses(&self, place: [f64; 2]) -> Option<String> {
        self.known.controller.refuses(place)
    }

    /// A goal that a sensor has interrupted is not gone on to: the crane would move when nobody expects it.
    fn heading(&self) -> bool {
        self.safe_state.drives() && self.known.controller.heading()
    }

    fn set_point(&self) -> Option<[f64; 2]> {
        self.known.controller.set_point()
    }

    fn set_point_in_space(&self) -> Option<[f64; 3]> {
        self.known.controller.set_point_in_space()
    }

    fn learnt(&self) -> Vec<LearntValve> {
        self.known.controller.learnt()
    }

    fn notices(&mut self) -> Vec<Report> {
        let (news, recovery) = (self.safe_state.take_news(), self.safe_state.monitor().recovery_time());
        let reports = news.iter().map(|notice| Report {
            text: notice.text(&self.names, recovery),
            alarm: matches!(notice, SensorNotice::Stops(..)).then_some(Alarm::SensorStop),
        });
        reports.chain(self.known.controller.notices()).collect()
    }
}
