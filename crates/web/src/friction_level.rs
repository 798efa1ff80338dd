//! The knob of friction after a replay: the level that a saved drive's forces amount to.

use crate::knobs::friction::{changes, is_force};
use crate::request::Request;
use hydrocrane_machine::OverrideValue;

/// Steps of a level that is found again in a saved drive: finer than any knob, coarser than rounding.
const STEPS: f64 = 1e6;

/// A saved drive states each friction force; where all of them are the machine's own times one level, the request says that
/// level in their place, so that the knob stands where it stood. The machine stays the same to the last bit.
pub fn settled(request: Request) -> Request {
    if !request.overrides.keys().any(|key| is_force(key)) {
        return request;
    }
    let mut bare = Request { friction: 1.0, ..request.clone() };
    bare.overrides.retain(|key, _| !is_force(key));
    level(&request, &bare).map_or(request, |friction| Request { friction, ..bare })
}

fn level(request: &Request, bare: &Request) -> Option<f64> {
    let forces = |request: &Request| request.machine(&[]).ok().map(|(machine, _)| machine);
    let (machine, wanted) = (forces(bare)?, changes(&forces(request)?, 1.0));
    let own = changes(&machine, 1.0);
    let ratios = own.iter().zip(&wanted).filter_map(|((_, own), (_, wanted))| Some(first(wanted)? / first(own)?));
    let level = (ratios.into_iter().find(|ratio| ratio.is_finite())? * STEPS).round() / STEPS;
    (changes(&machine, level) == wanted).then_some(level)
}

fn first(value: &OverrideValue) -> Option<f64> {
    match value {
        OverrideValue::Number(number) => Some(*number),
        OverrideValue::List(items) => items.first().and_then(first),
        _ => None,
    }
}
