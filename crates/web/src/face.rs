//! The cockpit as a page meets it: plain functions over numbers and bytes, no generated glue.
//!
//! Text goes in through [`input`] and comes out where [`text_at`] says, [`text_length`] bytes of UTF-8. A page that
//! meets a trap finds the reason by [`panic_at`] and [`panic_length`].

use crate::cockpit::Cockpit;
use serde_json::json;
use std::cell::RefCell;
use std::sync::Mutex;

/// Sticks of the largest machine.
const MOST_AXES: usize = 8;

#[derive(Default)]
struct Desk {
    cockpit: Cockpit,
    input: Vec<u8>,
    text: String,
    axes: [f64; MOST_AXES],
    frame: Vec<f64>,
}

thread_local! {
    static DESK: RefCell<Desk> = RefCell::default();
}

static PANIC: Mutex<String> = Mutex::new(String::new());

fn with<T>(act: impl FnOnce(&mut Desk) -> T) -> T {
    DESK.with(|desk| act(&mut desk.borrow_mut()))
}

/// To be called once, first.
#[no_mangle]
pub extern "C" fn start() {
    std::panic::set_hook(Box::new(|info| {
        if let Ok(mut text) = PANIC.lock() {
            *text = info.to_string();
        }
    }));
}

#[no_mangle]
pub extern "C" fn panic_at() -> *const u8 {
    PANIC.lock().map_or(std::ptr::null(), |text| text.as_ptr())
}

#[no_mangle]
pub extern "C" fn panic_length() -> usize {
    PANIC.lock().map_or(0, |text| text.len())
}

/// Room for `length` bytes of text that the next call reads.
#[no_mangle]
pub extern "C" fn input(length: usize) -> *mut u8 {
    with(|desk| {
        desk.input.clear();
        desk.input.resize(length, 0);
        desk.input.as_mut_ptr()
    })
}

#[no_mangle]
pub extern "C" fn text_at() -> *const u8 {
    with(|desk| desk.text.as_ptr())
}

#[no_mangle]
pub extern "C" fn text_length() -> usize {
    with(|desk| desk.text.len())
}

/// Begins the drive of the request in [`input`]; the text is its description, or `{"error": ...}`.
#[no_mangle]
pub extern "C" fn open() {
    with(|desk| {
        let request = String::from_utf8_lossy(&desk.input).into_owned();
        desk.axes = [0.0; MOST_AXES];
        desk.text = match desk.cockpit.open(&request) {
            Ok(description) => description.to_string(),
            Err(problem) => problem.json().to_string(),
        };
    });
}

/// Deflection of one axis.
#[no_mangle]
pub extern "C" fn steer(axis: usize, deflection: f64) {
    with(|desk| {
        if let Some(held) = desk.axes.get_mut(axis) {
            *held = deflection;
        }
        desk.cockpit.set_sticks(&desk.axes);
    });
}

/// The tip goes to a place (x, z), m, by itself; the text is empty, or `{"error": ...}` where it cannot.
#[no_mangle]
pub extern "C" fn go_to(x: f64, z: f64) {
    with(|desk| {
        desk.text = match desk.cockpit.go_to([x, z]) {
            Ok(()) => String::new(),
            Err(problem) => problem.json().to_string(),
        };
    });
}

/// The tip goes to no goal any more.
#[no_mangle]
pub extern "C" fn drop_goal() {
    with(|desk| desk.cockpit.drop_goal());
}

/// From the next sample on this share of the full speed counts.
#[no_mangle]
pub extern "C" fn precise(share: f64) {
    with(|desk| desk.cockpit.set_precision(share));
}

/// Payload from the next sample on, kg.
#[no_mangle]
pub extern "C" fn carry(mass: f64) {
    with(|desk| desk.cockpit.carry(mass));
}

/// Goes on by so many ms; one where the drive goes on, zero where it has ended.
#[no_mangle]
pub extern "C" fn advance(ticks: u32) -> u32 {
    with(|desk| u32::from(desk.cockpit.advance(ticks)))
}

/// Takes a row of numbers and tells their count; they lie where [`frame_at`] says until the next call.
#[no_mangle]
pub extern "C" fn frame() -> usize {
    with(|desk| {
        desk.frame.clear();
        desk.frame.extend_from_slice(desk.cockpit.frame());
        desk.frame.len()
    })
}

/// As [`frame`] for a recorded instant: the numbers of [`Cockpit::show`] in [`input`], as bytes, the least first.
#[no_mangle]
pub extern "C" fn show() -> usize {
    with(|desk| {
        let numbers = desk.input.chunks_exact(8).map(|bytes| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes));
        let recorded: Vec<f64> = numbers.collect();
        desk.frame.clear();
        desk.frame.extend_from_slice(desk.cockpit.show(&recorded));
        desk.frame.len()
    })
}

#[no_mangle]
pub extern "C" fn frame_at() -> *const f64 {
    with(|desk| desk.frame.as_ptr())
}

/// The text is what has happened since the last call.
#[no_mangle]
pub extern "C" fn events() {
    with(|desk| desk.text = desk.cockpit.events().to_string());
}

/// The text is the drive as a scenario file, `{"saved": ...}`, or `{"error": ...}`.
#[no_mangle]
pub extern "C" fn save() {
    with(|desk| {
        desk.text = match desk.cockpit.save() {
            Ok(text) => json!({ "saved": text }).to_string(),
            Err(problem) => problem.json().to_string(),
        };
    });
}
