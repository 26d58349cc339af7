//! The C face of optics and flow for the page: `wasm32-unknown-unknown`, no binding generator.
//!
//! A call: `text(bytes)` and `numbers(count)` give the places to write to, one function does the work and answers 0 or 1,
//! then `result`/`result_length` and `message`/`message_length` tell where the answer lies. Places move when memory
//! grows: ask for them after every call. After a trap `panic_message` has the words, and the instance is to be dropped.
//!
//! This is the one crate that may allow unsafe code: `no_mangle` is an unsafe attribute since edition 2024, because two
//! functions of one name would clash at link time. Nothing else here is unsafe, no address is ever taken from outside;
//! `tests/unsafe_code.rs` counts.
#![allow(unsafe_code, reason = "exported names only; see above")]

mod face;
mod film;
mod light;

/// Room for the text of the next call; where to write it.
#[unsafe(no_mangle)]
pub extern "C" fn text(bytes: usize) -> *mut u8 {
    face::with(|face| {
        face.text.clear();
        face.text.resize(bytes, 0);
        face.text.as_mut_ptr()
    })
}

/// Room for the numbers of the next call; where to write them.
#[unsafe(no_mangle)]
pub extern "C" fn numbers(count: usize) -> *mut f64 {
    face::with(|face| {
        face.numbers.clear();
        face.numbers.resize(count, 0.0);
        face.numbers.as_mut_ptr()
    })
}

/// Where the numbers of the last answer lie.
#[unsafe(no_mangle)]
pub extern "C" fn result() -> *const f64 {
    face::with(|face| face.result.as_ptr())
}

/// How many there are.
#[unsafe(no_mangle)]
pub extern "C" fn result_length() -> usize {
    face::with(|face| face.result.len())
}

/// Where the words of the last answer lie.
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    face::with(|face| face.message.as_ptr())
}

/// How many bytes they are.
#[unsafe(no_mangle)]
pub extern "C" fn message_length() -> usize {
    face::with(|face| face.message.len())
}

/// Called once, before all others.
#[unsafe(no_mangle)]
pub extern "C" fn begin() {
    face::hear_panics();
}

/// Where the words of a panic lie, after a trap.
#[unsafe(no_mangle)]
pub extern "C" fn panic_message() -> *const u8 {
    face::panic_words().0
}

/// How many bytes they are; 0: nothing panicked.
#[unsafe(no_mangle)]
pub extern "C" fn panic_length() -> usize {
    face::panic_words().1
}

/// Exports calls of one kind: each answers 0, or 1 with the message.
macro_rules! calls {
    ($($(#[$doc:meta])* $name:ident = $module:ident::$work:ident;)*) => {$(
        $(#[$doc])*
        #[unsafe(no_mangle)]
        pub extern "C" fn $name() -> i32 {
            face::answer($module::$work)
        }
    )*};
}

calls! {
    /// The items of a stack.
    stack_describe = light::describe;
    /// All built-in media.
    media_list = light::media;
    /// All built-in illuminants.
    illuminant_list = light::illuminants;
    /// Colours of a stack.
    stack_color = light::color;
    /// A table of a stack's colours.
    color_table = light::table;
    /// A spectrum of a stack.
    stack_spectrum = light::spectrum;
    /// Colours from one space into another.
    color_convert = light::convert;
    /// CIEDE2000.
    color_difference = light::delta_e;
    /// A lamp.
    illuminant_describe = light::illuminant;
    /// The observer.
    observer_table = light::observer;
    /// Refractive indices.
    medium_index = light::index;
    /// Films that can flow.
    flow_presets = film::presets;
    /// A new film.
    flow_start = film::start;
    /// The film at a later time.
    flow_advance = film::advance;
    /// Another value of one of its parameters.
    flow_change = film::change;
    /// A breath of air.
    flow_stir = film::stir;
    /// Swirls.
    thickness_swirls = film::swirls;
    /// The gap under a lens.
    thickness_lens_gap = film::lens_gap;
}
