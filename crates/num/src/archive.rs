//! Numbers of an object as bytes: one function visits them, for writing and for reading.

/// Numbers that are written to bytes or read from them.
#[derive(Debug)]
pub struct Archive<'a> {
    #[cfg(feature = "std")]
    written: Vec<u8>,
    /// Remaining bytes; `None` while writing.
    left: Option<&'a [u8]>,
    damaged: bool,
}

impl<'a> Archive<'a> {
    #[cfg(feature = "std")]
    pub fn writing() -> Self {
        Archive { written: Vec::new(), left: None, damaged: false }
    }

    pub fn reading(bytes: &'a [u8]) -> Self {
        Archive {
            #[cfg(feature = "std")]
            written: Vec::new(),
            left: Some(bytes),
            damaged: false,
        }
    }

    pub fn reads(&self) -> bool {
        self.left.is_some()
    }

    /// The written bytes.
    #[cfg(feature = "std")]
    pub fn into_bytes(self) -> Vec<u8> {
        self.written
    }

    /// Whether exactly all bytes were read.
    pub fn is_sound(&self) -> bool {
        !self.damaged && self.left.is_none_or(<[u8]>::is_empty)
    }

    /// Takes note that a number that was read cannot be one that was written.
    pub fn spoil(&mut self) {
        self.damaged = true;
    }

    pub fn whole(&mut self, value: &mut u64) {
        match &mut self.left {
            #[cfg(feature = "std")]
            None => self.written.extend(value.to_le_bytes()),
            #[cfg(not(feature = "std"))]
            None => self.damaged = true,
            Some(left) => match left.split_first_chunk::<8>() {
                Some((bytes, rest)) => (*value, *left) = (u64::from_le_bytes(*bytes), rest),
                None => self.damaged = true,
            },
        }
    }

    /// All bits of a number.
    pub fn number(&mut self, value: &mut f64) {
        let mut bits = value.to_bits();
        self.whole(&mut bits);
        *value = f64::from_bits(bits);
    }

    /// Numbers whose count does not change.
    pub fn numbers(&mut self, values: &mut [f64]) {
        values.iter_mut().for_each(|value| self.number(value));
    }

    pub fn flag(&mut self, value: &mut bool) {
        let mut whole = u64::from(*value);
        self.whole(&mut whole);
        *value = whole != 0;
    }

    /// A value that may be missing, by its own `walk`.
    pub fn option<T: Default>(&mut self, value: &mut Option<T>, walk: impl FnOnce(&mut Self, &mut T)) {
        let mut there = value.is_some();
        self.flag(&mut there);
        *value = there.then(|| {
            let mut inner = value.take().unwrap_or_default();
            walk(self, &mut inner);
            inner
        });
    }
}

#[cfg(test)]
mod tests {
    use super::Archive;

    type Things = (u64, f64, [f64; 2], bool, Option<f64>, Option<f64>);

    fn walk(archive: &mut Archive, (whole, number, numbers, flag, some, none): &mut Things) {
        archive.whole(whole);
        archive.number(number);
        archive.numbers(numbers);
        archive.flag(flag);
        archive.option(some, Archive::number);
        archive.option(none, Archive::number);
    }

    #[test]
    fn what_is_written_is_read_back_to_the_bit_and_too_few_or_too_many_bytes_are_damage() {
        let mut things: Things = (7, -0.0, [f64::NAN, 1e-310], true, Some(0.1), None);
        let mut archive = Archive::writing();
        walk(&mut archive, &mut things);
        let bytes = archive.into_bytes();
        let mut found: Things = (0, 1.0, [0.0; 2], false, None, Some(3.0));
        let mut archive = Archive::reading(&bytes);
        walk(&mut archive, &mut found);
        assert!(archive.is_sound());
        let bits = |t: &Things| (t.0, t.1.to_bits(), t.2.map(f64::to_bits), t.3, t.4, t.5);
        assert_eq!(bits(&found), bits(&things));
        let longer = [&bytes[..], &[0]].concat();
        for damaged in [&bytes[1..], &longer] {
            let mut archive = Archive::reading(damaged);
            walk(&mut archive, &mut found);
            assert!(!archive.is_sound());
        }
    }
}
