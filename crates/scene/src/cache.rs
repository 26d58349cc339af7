//! Things that took time to make, kept for the next question.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// What is kept of things that the last question did not use, bytes.
const MOST_KEPT: usize = 512 << 20;

/// Values by their keys. What the last question used is kept, whatever it takes; of older things, the latest, up to 512
/// MiB.
#[derive(Debug)]
pub struct Cache<K, V> {
    state: Mutex<State<K, V>>,
}

#[derive(Debug)]
struct State<K, V> {
    question: u64,
    entries: Vec<Entry<K, V>>,
}

#[derive(Debug)]
struct Entry<K, V> {
    key: K,
    value: V,
    bytes: usize,
    used: u64,
}

impl<K, V> Default for Cache<K, V> {
    fn default() -> Cache<K, V> {
        Cache { state: Mutex::new(State { question: 0, entries: Vec::new() }) }
    }
}

impl<K: Clone + PartialEq, V: Clone> Cache<K, V> {
    /// Another question begins: what was used for the one before may be forgotten, if there is too much of it.
    pub fn next_question(&self) {
        let mut state = self.state();
        let last = state.question;
        state.question += 1;
        state.entries.sort_by_key(|entry| std::cmp::Reverse(entry.used));
        let mut older = 0;
        state.entries.retain(|entry| {
            older += if entry.used < last { entry.bytes } else { 0 };
            older <= MOST_KEPT
        });
    }

    /// The value of a key, made now (with its size in bytes) if it is not known. Two threads that need the same one at
    /// the same time both make it: nobody waits for another's work, which may be stopped.
    pub fn get<E>(&self, key: &K, make: impl FnOnce() -> Result<(usize, V), E>) -> Result<V, E> {
        {
            let mut state = self.state();
            let question = state.question;
            if let Some(entry) = state.entries.iter_mut().find(|entry| entry.key == *key) {
                entry.used = question;
                return Ok(entry.value.clone());
            }
        }
        let (bytes, value) = make()?;
        let mut state = self.state();
        let used = state.question;
        state.entries.retain(|entry| entry.key != *key);
        state.entries.push(Entry { key: key.clone(), value: value.clone(), bytes, used });
        Ok(value)
    }

    fn state(&self) -> MutexGuard<'_, State<K, V>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_question_is_kept_whole_and_older_ones_up_to_a_size() {
        let cache: Cache<u32, u32> = Cache::default();
        let made = std::cell::Cell::new(0);
        let get = |key: u32| {
            let make = || {
                made.set(made.get() + 1);
                Ok::<_, ()>((MOST_KEPT / 2, key * 10))
            };
            assert_eq!(cache.get(&key, make), Ok(key * 10));
            made.get()
        };
        cache.next_question();
        assert_eq!((get(1), get(2), get(3), get(1)), (1, 2, 3, 3));
        cache.next_question();
        assert_eq!((get(1), get(2), get(3)), (3, 3, 3), "as large as it is, the last question stays");
        cache.next_question();
        assert_eq!(get(4), 4);
        cache.next_question();
        // The three are older now, and two of them fit.
        assert_eq!(get(4), 4);
        let again = [1, 2, 3].map(|key| get(key) - 4).iter().max().copied();
        assert_eq!(again, Some(1), "one was forgotten");
        assert!(cache.get(&9, || Err::<(usize, u32), &str>("no")) == Err("no"));
    }
}
