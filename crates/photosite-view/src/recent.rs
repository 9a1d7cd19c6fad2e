//! Cache of the most recently used of few values.

/// Cache of the most recently used of few values, by their keys.
pub(super) struct Recent<K, V> {
    values: Vec<(K, V)>,
    most: usize,
}

impl<K: PartialEq, V: Clone> Recent<K, V> {
    /// Cache that keeps the values of at most `most` keys.
    pub(super) const fn new(most: usize) -> Self {
        Self { values: Vec::new(), most }
    }

    /// The value of a key, made where it is not kept.
    pub(super) fn get_or_make<E>(&mut self, key: K, make: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        let value = match self.values.iter().position(|(known, _)| *known == key) {
            Some(place) => self.values.remove(place).1,
            None => make()?,
        };
        self.values.truncate(self.most - 1);
        self.values.insert(0, (key, value.clone()));
        Ok(value)
    }

    /// Changes values that are kept.
    pub(super) fn each(&mut self, change: impl Fn(&K, &mut V)) {
        self.values.iter_mut().for_each(|(key, value)| change(key, value));
    }

    /// Forgets values whose keys are no longer asked for.
    pub(super) fn retain(&mut self, is_kept: impl Fn(&K) -> bool) {
        self.values.retain(|(key, _)| is_kept(key));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_few_are_kept() {
        let mut recent = Recent::new(4);
        let mut get = |key: u32| {
            let mut is_made = false;
            let value = recent.get_or_make(key, || {
                is_made = true;
                Ok::<_, ()>(key * 10)
            });
            assert_eq!(value, Ok(key * 10));
            is_made
        };
        assert!(get(1) && get(2) && get(3) && get(4));
        assert!(!get(1), "the oldest, and now the newest");
        assert!(get(5) && get(2), "2 has given way to 5");
        assert!(!get(1) && !get(4));
        let refused: Result<u32, &str> = recent.get_or_make(9, || Err("no"));
        assert_eq!(refused, Err("no"));
    }
}
