//! Results that are kept beside the inputs that they were made from.

use crate::error::Error;
use crate::meter;
use std::ops::Deref;
use std::sync::Arc;

/// The last result of a step and the input that it was made from.
pub struct Step<I, O>(Option<(I, O)>);

impl<I, O> Default for Step<I, O> {
    fn default() -> Self {
        Self(None)
    }
}

impl<I: PartialEq, O: Clone> Step<I, O> {
    /// The result for `input`: the last one if the input is the same, else a new one.
    ///
    /// # Errors
    /// Those of `make`. Nothing is kept then.
    pub fn get(&mut self, input: I, make: impl FnOnce(&I) -> Result<O, Error>) -> Result<O, Error> {
        if let Some((known, result)) = &self.0
            && *known == input
        {
            return Ok(result.clone());
        }
        // The last result goes before the new one takes memory.
        self.0 = None;
        meter::check();
        let result = make(&input)?;
        self.0 = Some((input, result.clone()));
        Ok(result)
    }

    /// The last result.
    pub fn last(&self) -> Option<&O> {
        self.0.as_ref().map(|(_, result)| result)
    }
}

/// A shared value that equals itself alone, so that comparing costs nothing.
pub struct Same<T: ?Sized>(pub Arc<T>);

impl<T: ?Sized> PartialEq for Same<T> {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl<T: ?Sized> Deref for Same<T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.0
    }
}

impl<T: ?Sized> From<&Arc<T>> for Same<T> {
    fn from(value: &Arc<T>) -> Self {
        Self(Arc::clone(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_repeats_when_its_input_changes() {
        let (mut step, mut count) = (Step::default(), 0);
        let mut get = |input: usize| {
            let result = step.get(input, |&input| {
                count += 1;
                Ok(Arc::new(10 * input))
            });
            (*result.expect("a result"), count)
        };
        assert_eq!([get(1), get(1), get(2), get(1)], [(10, 1), (10, 1), (20, 2), (10, 3)]);
    }

    #[test]
    fn a_failure_is_not_kept() {
        let mut step: Step<usize, usize> = Step::default();
        assert!(step.get(1, |_| Err(Error::internal("no"))).is_err());
        assert_eq!(step.get(1, |_| Ok(2)).ok(), Some(2));
        assert_eq!(step.last(), Some(&2));
    }

    #[test]
    fn equal_values_in_other_places_are_not_the_same() {
        let value = Arc::new(1);
        assert!(Same::from(&value) == Same::from(&value));
        assert!(Same::from(&value) != Same(Arc::new(1)));
    }
}
