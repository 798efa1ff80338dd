//! One value of a table: converts it to SI and checks its type, unit, dimension and sign.

use crate::errors::{ErrorKind, MachineError};
use crate::keys::{Key, Sign};
use crate::model::{Form, Provenance, ProvenanceClass, Recorded, Unusual};
use crate::nearest::{choose, symbol_suggestion};
use crate::number::Number;
use crate::reading::log::Log;
use crate::reading::plausible::{self, Plausibility};
use crate::text::document::{Origin, Place, Scalar};
use crate::units::misread;
use crate::units::quantities;
use crate::units::quantities::Kind;
use crate::units::{self, Quantity, Unit, UnitError};

type Result<T> = std::result::Result<T, MachineError>;

pub const POINT_EXAMPLE: &str = "a point, for example \"(0.2, -0.1) m\"";

/// Most values of one list: sticks for an hour at 100 Hz.
pub const MOST_ROWS: usize = 400_000;

/// A value with the data for messages about it.
#[derive(Clone)]
pub struct Field<'a> {
    pub path: String,
    pub place: &'a Place,
    pub value: &'a Scalar,
    pub origin: &'a Origin,
    pub log: &'a Log,
    /// Its declaration.
    pub key: &'static Key,
}

impl<'a> Field<'a> {
    pub fn error(&self, kind: ErrorKind, message: impl Into<String>) -> MachineError {
        self.place.error(kind, &self.path, message)
    }

    fn wrong_type(&self, expected: &str) -> MachineError {
        let found = format!("expected {expected}, found {}", self.value.kind_name());
        self.error(ErrorKind::WrongType, found).help(format!("give {expected}"))
    }

    fn class(&self) -> Result<Option<ProvenanceClass>> {
        self.log.class(&self.path, self.place, self.origin)
    }

    pub fn text(&self) -> Result<&'a str> {
        match self.value {
            Scalar::Text(text) => {
                self.log.word(&self.path, text);
                Ok(text)
            }
            _ => Err(self.wrong_type("a text in quotes")),
        }
    }

    /// The declared choice that it names; `values` are the meanings of the choices, in their order.
    pub fn choice<T: Copy>(&self, values: &[T]) -> Result<T> {
        let names = self.key.choices();
        debug_assert_eq!(names.len(), values.len(), "`{}` is declared with other choices", self.path);
        let choices: Vec<(&str, T)> = names.iter().copied().zip(values.iter().copied()).collect();
        self.choice_of(&choices)
    }

    /// As [`Self::choice`] with choices that depend on other values of the file.
    pub fn choice_of<T: Copy>(&self, choices: &[(&str, T)]) -> Result<T> {
        debug_assert!(choices.iter().all(|(name, _)| self.key.choices().contains(name)), "`{}`", self.path);
        let text = self.text()?;
        choose(text, choices).map_err(|help| {
            self.error(ErrorKind::InvalidChoice, format!("`{text}` is not among the choices")).help(help)
        })
    }

    /// Adds a warning on an allowed but unusual value, with its cure.
    pub fn warn(&self, text: String, cure: String) {
        self.log.warn(Unusual { key: self.path.clone(), place: self.place.to_string(), text, cure });
    }

    /// A quantity that depends on other values of the file.
    pub fn quantity_of<T: Number>(&self, quantity: &Quantity) -> Result<T> {
        let value = self.plain_quantity_of(quantity)?;
        Ok(self.log.number(&self.path, None, value))
    }

    /// Whether it is a text with a unit of this quantity.
    pub fn is(&self, quantity: &Quantity) -> bool {
        let Scalar::Text(text) = self.value else { return false };
        units::parse_scalar(text).is_ok_and(|(_, unit)| unit.dimension == quantity.dimension)
    }

    /// A quantity that may also be stated as `other`; one of that counts `factor` in SI.
    pub fn quantity_or<T: Number>(&self, quantity: &Quantity, other: &Quantity, factor: f64) -> Result<T> {
        if !self.is(other) {
            return self.quantity_of(quantity);
        }
        let class = self.class()?;
        let value = factor * self.scalar(self.value, self.place, other)?;
        self.keep(class, &[value], &[quantity], Form::One);
        Ok(self.log.number(&self.path, None, value))
    }

    /// What the file states in the place of an override, else this value.
    pub fn quantity_of_file(&self) -> Result<f64> {
        let quantity = self.kind().quantity();
        let of_file = self.origin.of_file.as_ref().and_then(|value| self.signed(value, self.place, &quantity).ok());
        let (_, si) = of_file.map_or_else(|| self.signed(self.value, self.place, &quantity), Ok)?;
        Ok(si)
    }

    fn plain_quantity_of(&self, quantity: &Quantity) -> Result<f64> {
        debug_assert!(self.key.allows(quantity), "`{}` is declared as another quantity", self.path);
        let class = self.class()?;
        let value = self.scalar(self.value, self.place, quantity)?;
        self.keep(class, &[value], &[quantity], Form::One);
        Ok(value)
    }

    fn keep(&self, class: Option<ProvenanceClass>, si: &[f64], quantities: &[&Quantity], form: Form) {
        let Some(class) = class else { return };
        let units = quantities.iter().map(|quantity| quantity.unit.clone()).collect();
        let value = Recorded { si: si.to_vec(), units, form };
        let entry = Provenance { key: self.path.clone(), class, source: self.origin.source.clone(), value };
        self.log.keep(self.value, entry);
    }

    /// A pair of the declared quantity.
    pub fn pair<T: Number>(&self) -> Result<[T; 2]> {
        let quantity = self.kind().quantity();
        self.pair_of([&quantity, &quantity])
    }

    fn kind(&self) -> Kind {
        self.key.kind().unwrap_or_else(|| panic!("`{}` is declared as no quantity", self.path))
    }

    /// A value that applies to both entries, or a list of two; `quantities` has the quantity of each entry.
    pub fn pair_of<T: Number>(&self, quantities: [&Quantity; 2]) -> Result<[T; 2]> {
        Ok(self.numbers(self.plain_pair_of(quantities)?))
    }

    fn numbers<T: Number>(&self, pair: [f64; 2]) -> [T; 2] {
        [0, 1].map(|element| self.log.number(&self.path, Some(element), pair[element]))
    }

    fn plain_pair_of(&self, quantities: [&Quantity; 2]) -> Result<[f64; 2]> {
        debug_assert!(quantities.iter().all(|quantity| self.key.allows(quantity)), "`{}`", self.path);
        let class = self.class()?;
        let [a, b] = match self.value {
            Scalar::List(items) => match items.as_slice() {
                [a, b] => [(&a.0, &a.1), (&b.0, &b.1)],
                _ => {
                    return Err(self
                        .error(ErrorKind::WrongType, format!("expected two values, found {}", items.len()))
                        .help("give one value for both, or a list of two"))
                }
            },
            value => [(value, self.place); 2],
        };
        let pair = [self.scalar(a.0, a.1, quantities[0])?, self.scalar(b.0, b.1, quantities[1])?];
        let form = if matches!(self.value, Scalar::List(_)) { Form::Two } else { Form::Shared };
        self.keep(class, &pair, &quantities, form);
        Ok(pair)
    }

    /// A list of quantities of the declared kind.
    pub fn series(&self) -> Result<Vec<f64>> {
        let class = self.class()?;
        let quantity = &self.kind().quantity();
        let items = self.list()?;
        let numbers = items.iter().map(|(value, place)| Ok(self.signed(value, place, quantity)?.1));
        let series = numbers.collect::<Result<Vec<f64>>>()?;
        // Only the largest value is checked, because series are long.
        let largest = (0..series.len()).max_by(|a, b| series[*a].abs().total_cmp(&series[*b].abs()));
        if let Some((value, place)) = largest.map(|index| &items[index]) {
            self.scalar(value, place, quantity)?;
        }
        self.keep(class, &series, &[quantity], Form::List);
        Ok(series)
    }

    /// A list of points.
    pub fn points(&self) -> Result<Vec<[f64; 2]>> {
        let class = self.class()?;
        let items = self.list()?.iter().map(|(value, place)| self.point_from(value, place));
        let points = items.collect::<Result<Vec<[f64; 2]>>>()?;
        self.keep(class, &points.concat(), &[&quantities::LENGTH.quantity()], Form::List);
        Ok(points)
    }

    pub fn texts(&self) -> Result<Vec<&'a str>> {
        let texts = self.list()?.iter().map(|(value, _)| match value {
            Scalar::Text(text) => Ok(text.as_str()),
            _ => Err(self.error(ErrorKind::WrongType, "expected a list of texts").help("put each in quotes")),
        });
        texts.collect()
    }

    fn list(&self) -> Result<&'a [(Scalar, Place)]> {
        match self.value {
            Scalar::List(items) if items.len() <= MOST_ROWS => Ok(items),
            Scalar::List(items) => {
                let message = format!("a list of {} values; at most {MOST_ROWS} are read", items.len());
                Err(self.error(ErrorKind::TooLarge, message).help("give fewer, further apart"))
            }
            _ => Err(self.wrong_type("a list")),
        }
    }

    /// A point as x, y, z: of two numbers these are x and z, in the plane.
    pub fn point<T: Number>(&self) -> Result<[T; 3]> {
        let class = self.class()?;
        let point = self.numbers_from(self.value, self.place)?;
        let length = quantities::LENGTH.quantity();
        self.keep(class, &point, &vec![&length; point.len()], Form::Two);
        let number = |element: usize| self.log.number(&self.path, Some(element), point[element]);
        Ok(match point.len() {
            2 => [number(0), T::c(0.0), number(1)],
            _ => [number(0), number(1), number(2)],
        })
    }

    /// A point in the plane.
    fn point_from(&self, value: &Scalar, place: &Place) -> Result<[f64; 2]> {
        match self.numbers_from(value, place)?.as_slice() {
            [x, z] => Ok([*x, *z]),
            _ => Err(place
                .error(ErrorKind::WrongType, &self.path, "a point with three numbers")
                .help("this one lies in the plane of x and z: leave out y")),
        }
    }

    fn numbers_from(&self, value: &Scalar, place: &Place) -> Result<Vec<f64>> {
        let length = quantities::LENGTH.quantity();
        let report = |message: String| {
            place.error(ErrorKind::WrongType, &self.path, message).help(format!("give {POINT_EXAMPLE}"))
        };
        let (numbers, unit) = match (value, place) {
            (Scalar::Text(text), _) => {
                units::parse_point(text).map_err(|error| self.unit_error(error, text, place, &length, POINT_EXAMPLE))?
            }
            // A caller may give the point as two numbers in SI.
            (Scalar::List(items), Place::Override(_)) => match items.as_slice() {
                [(Scalar::Number(x), _), (Scalar::Number(z), _)] => (vec![*x, *z], si(&length)),
                [(Scalar::Number(x), _), (Scalar::Number(y), _), (Scalar::Number(z), _)] => {
                    (vec![*x, *y, *z], si(&length))
                }
                _ => return Err(report("expected two or three numbers".into())),
            },
            _ => return Err(report(format!("expected a point, found {}", value.kind_name()))),
        };
        let convert = |number: f64| {
            let converted = self.convert(number, unit, "", place, &length)?;
            self.judge(number, None, converted, place, &length)?;
            Ok(converted)
        };
        numbers.into_iter().map(convert).collect()
    }

    /// A value in SI, of the right sign and size.
    fn scalar(&self, value: &Scalar, place: &Place, quantity: &Quantity) -> Result<f64> {
        let (number, converted) = self.signed(value, place, quantity)?;
        let written = if let Scalar::Text(text) = value { Some(text.trim()) } else { None };
        self.judge(number, written, converted, place, quantity)?;
        Ok(converted)
    }

    /// A number as it was given and in SI, of the right sign.
    fn signed(&self, value: &Scalar, place: &Place, quantity: &Quantity) -> Result<(f64, f64)> {
        let (number, unit) = match value {
            // Numbers of callers are SI; a file states the unit.
            Scalar::Number(number) if quantity.is_number() || matches!(place, Place::Override(_)) => {
                (*number, si(quantity))
            }
            Scalar::Number(number) => return Err(self.missing_unit(place, quantity, *number, "the unit is missing")),
            Scalar::Text(text) => units::parse_scalar(text)
                .map_err(|error| self.unit_error(error, text, place, quantity, &quantity.example()))?,
            _ => {
                let found = format!("expected {}, found {}", units::with_article(quantity.name), value.kind_name());
                let help = format!("give {}", quantity.example());
                return Err(place.error(ErrorKind::WrongType, &self.path, found).help(help));
            }
        };
        let written = if let Scalar::Text(text) = value { text } else { "" };
        let converted = self.convert(number, unit, written, place, quantity)?;
        let sign = self.key.sign();
        let allowed = match sign {
            Sign::Any => true,
            Sign::NonNegative => converted >= 0.0,
            Sign::Positive => converted > 0.0,
        };
        if allowed {
            return Ok((number, converted));
        }
        let needed = if sign == Sign::Positive { "greater than zero" } else { "zero or greater" };
        let help = format!("give {} {needed}", units::with_article(quantity.name));
        Err(place.error(ErrorKind::OutOfRange, &self.path, format!("must be {needed}, found {number}")).help(help))
    }

    /// Refuses a value far from the usual range, and adds a warning on an unusual one. `number` is the given number in
    /// the unit of the text `written`; without a text it is in SI.
    fn judge(&self, number: f64, written: Option<&str>, si: f64, place: &Place, quantity: &Quantity) -> Result<()> {
        let found = plausible::judge(self.key, quantity, number, si);
        let in_si = || format!("{} {}", plausible::short(si), quantity.unit).trim_end().to_string();
        let shown = || written.map_or_else(in_si, str::to_string);
        match found {
            Plausibility::Usual => Ok(()),
            Plausibility::Unusual(usual, cure) => {
                let place = place.to_string();
                self.log.warn(Unusual { key: self.path.clone(), place, text: format!("{}; {usual}", shown()), cure });
                Ok(())
            }
            Plausibility::Refused(usual, cure) => {
                let message = format!("{} is beyond any use; {usual}", shown());
                Err(place.error(ErrorKind::OutOfRange, &self.path, message).help(cure))
            }
        }
    }

    fn convert(&self, number: f64, unit: Unit, written: &str, place: &Place, quantity: &Quantity) -> Result<f64> {
        if unit.dimension != quantity.dimension {
            if let Some(cure) = misread::instead(written, Some(quantity.dimension)) {
                return Err(place
                    .error(ErrorKind::UnknownUnit, &self.path, format!("`{written}` is not read"))
                    .help(cure));
            }
            if unit.dimension == units::Dimension::NONE {
                let share = unit.factor != 1.0;
                let lacking = if share { "a share, and nothing says of what" } else { "the unit is missing" };
                return Err(self.missing_unit(place, quantity, number, lacking));
            }
            let found = quantities::name_of(unit.dimension).map_or("another quantity".into(), units::with_article);
            let wanted = units::with_article(quantity.name);
            let message = format!("expected {wanted} ({}), found {found} ({})", quantity.dimension, unit.dimension);
            let lacks = |factor: &'static str, power: f64| {
                unit.dimension.combine(units::own_unit(factor).dimension, power) == quantity.dimension
            };
            let help = if lacks("rad", 1.0) {
                format!("write {number} rpm, Hz or rad/s: a plain 1/s or 1/min does not say whether it counts turns or radians")
            } else if lacks("m/s^2", 1.0) {
                "kg and t are masses: write kgf and tf for their weights".into()
            } else if lacks("m/s^2", -1.0) {
                "this is a weight: write kg or t for the mass".into()
            } else {
                format!("give {}", quantity.example())
            };
            return Err(place.error(ErrorKind::WrongDimension, &self.path, message).help(help));
        }
        let converted = unit.to_si(number);
        if converted.is_finite() {
            return Ok(converted);
        }
        let help = format!("give a finite {}", quantity.name);
        Err(place.error(ErrorKind::NotFinite, &self.path, "the value is not finite").help(help))
    }

    fn missing_unit(&self, place: &Place, quantity: &Quantity, number: f64, lacking: &str) -> MachineError {
        let unit = quantity.written();
        let wanted = units::with_article(quantity.name);
        let help = format!("give {wanted} with its unit, for example \"{} {unit}\"", plausible::short(number));
        place.error(ErrorKind::MissingUnit, &self.path, lacking).help(help)
    }

    /// The nearest known symbol with which `text` is this quantity, or another that the key holds, of a usual size.
    fn meant(&self, text: &str, symbol: &str, quantity: &Quantity) -> String {
        let mut fitting = units::meant(text, symbol);
        fitting.retain(|meant| self.key.kinds().iter().any(|kind| kind.quantity().dimension == meant.unit.dimension));
        if fitting.is_empty() {
            return format!("give {}", quantity.example());
        }
        let sized = fitting.iter().map(|of| {
            let size = plausible::size(self.key, of.unit.dimension, of.unit.to_si(of.number));
            (of.symbol, if of.unit.dimension == quantity.dimension { size } else { size.max(1) })
        });
        symbol_suggestion(symbol, &sized.collect::<Vec<_>>())
    }

    fn unit_error(
        &self,
        error: UnitError,
        text: &str,
        place: &Place,
        quantity: &Quantity,
        example: &str,
    ) -> MachineError {
        match error {
            UnitError::Malformed(message) => {
                place.error(ErrorKind::BadQuantity, &self.path, message).help(format!("give {example}"))
            }
            UnitError::Unknown(symbol) => {
                let instead = misread::instead(text, Some(quantity.dimension));
                let help = instead.unwrap_or_else(|| self.meant(text, &symbol, quantity));
                place.error(ErrorKind::UnknownUnit, &self.path, format!("unknown unit `{symbol}`")).help(help)
            }
        }
    }
}

/// The SI unit of a quantity.
fn si(quantity: &Quantity) -> Unit {
    Unit { factor: 1.0, dimension: quantity.dimension }
}
