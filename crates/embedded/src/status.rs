//! What a function answers.

use core::ffi::CStr;
use hydrocrane_control::interface::controller::Fault;
use hydrocrane_control::parameter_block::Refusal;

macro_rules! statuses {
    ($($number:literal $name:ident $text:literal;)*) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(i32)]
        pub enum Status {
            $($name = $number,)*
        }

        pub fn text(status: i32) -> &'static CStr {
            match status {
                $($number => $text,)*
                _ => c"no status of this library",
            }
        }
    };
}

statuses! {
    0 Ok c"all is well";
    1 NullPointer c"a pointer is null";
    2 Misaligned c"memory or numbers do not lie at a multiple of 8 bytes";
    3 TooLittleMemory c"the memory is too small: give HYDROCRANE_MEMORY bytes";
    4 NoParameters c"these are no controller parameters";
    5 Damaged c"the parameters are damaged: their length or their checksum is wrong";
    6 OtherVersion c"the parameters are of another version than the library: export them again";
    7 OtherJoints c"this library was compiled without this number of joints";
    8 NotCreated c"there is no controller in this memory: call hydrocrane_create first";
    9 BadMeasurement c"a measurement is not a finite number, or is beyond 1e12";
    10 BadStick c"a stick is not a finite number between -1 and 1, or has another number of axes";
    11 WrongStick c"this controller does not take sticks of this mode";
    12 NoCommand c"the controller found no finite command";
    13 NoSetPoint c"this controller has no set-point, or has not begun";
    14 TooFewRevolute c"heinze-pid needs two revolute joints";
    15 OtherSpools c"there is room for another number of spool commands than the controller gives";
}

impl From<Refusal> for Status {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::NoParameters => Status::NoParameters,
            Refusal::Damaged => Status::Damaged,
            Refusal::OtherVersion => Status::OtherVersion,
        }
    }
}

impl From<Fault> for Status {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::BadMeasurement(_) => Status::BadMeasurement,
            Fault::BadStick | Fault::StickAxes(..) | Fault::BadGoal(_) => Status::BadStick,
            Fault::WrongStick(_) => Status::WrongStick,
            Fault::NoCommand => Status::NoCommand,
            Fault::TooFewRevolute(_) => Status::TooFewRevolute,
        }
    }
}
