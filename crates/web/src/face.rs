//! What passes between the page and the core, and what the core remembers between two calls.
//!
//! The page writes a text and numbers into two buffers that live here, calls one function, and reads numbers and a text
//! from two others. No address ever comes in: Rust hands out where its own vectors lie, so nothing here needs `unsafe`
//! but the exported names (`lib.rs`).

use std::cell::RefCell;
use std::sync::{Mutex, PoisonError};

use iridesce_flow::Film;
use iridesce_optics::color::StackColor;

/// Stacks that are kept ready: a page shows a handful at once.
const KEPT: usize = 12;

/// Both sides of a call.
#[derive(Default)]
pub struct Face {
    /// Text that the page wrote, UTF-8.
    pub text: Vec<u8>,
    /// Numbers that the page wrote.
    pub numbers: Vec<f64>,
    /// Numbers that the page reads.
    pub result: Vec<f64>,
    /// What went wrong, or a result in words.
    pub message: String,
    /// Colour sums made ready, by what was asked for; the last used at the end.
    pub colors: Vec<(String, StackColor)>,
    /// The film that flows, if one does.
    pub film: Option<Film>,
}

thread_local! {
    static FACE: RefCell<Face> = RefCell::default();
}

/// What a panic said. Apart from the face, which a panic leaves borrowed.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// Lends the face.
pub fn with<T>(work: impl FnOnce(&mut Face) -> T) -> T {
    FACE.with_borrow_mut(work)
}

/// Runs a call: 0 where it succeeded, 1 where the message says what was wrong.
pub fn answer(work: impl FnOnce(&mut Face) -> Result<(), String>) -> i32 {
    with(|face| {
        face.result.clear();
        face.message.clear();
        match work(face) {
            Ok(()) => 0,
            Err(message) => {
                face.message = message;
                1
            }
        }
    })
}

impl Face {
    /// The lines of the text; missing ones are empty.
    pub fn lines<const N: usize>(&self) -> Result<[String; N], String> {
        let text = std::str::from_utf8(&self.text).map_err(|_| "the text must be UTF-8".to_owned())?;
        let mut lines = text.split('\n');
        Ok(std::array::from_fn(|_| lines.next().unwrap_or_default().to_owned()))
    }

    /// Takes the colour sums of a request out of those kept ready, or makes them.
    pub fn color(
        &mut self,
        key: &str,
        make: impl FnOnce() -> Result<StackColor, String>,
    ) -> Result<&StackColor, String> {
        let kept = match self.colors.iter().position(|(known, _)| known == key) {
            Some(place) => self.colors.remove(place),
            None => (key.to_owned(), make()?),
        };
        if self.colors.len() >= KEPT {
            self.colors.remove(0);
        }
        self.colors.push(kept);
        Ok(&self.colors[self.colors.len() - 1].1)
    }
}

/// Keeps what a panic says, so that the page can tell it after the trap; the instance is then thrown away.
pub fn hear_panics() {
    std::panic::set_hook(Box::new(|info| {
        *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = info.to_string();
    }));
}

/// Where the words of the last panic lie, and how many bytes they are.
pub fn panic_words() -> (*const u8, usize) {
    let words = PANIC.lock().unwrap_or_else(PoisonError::into_inner);
    (words.as_ptr(), words.len())
}
