//! One formula, many instances: the film and the march of a layer in double precision one at a time, in lanes of double and
//! of single precision, at every level of SIMD that this machine has, compared with one another.

use fearless_simd::{Level, Simd, dispatch, f32x16, f64x8, prelude::*};
use iridesce_numerics::noise::SplitMix64;
use iridesce_numerics::simd::levels;
use iridesce_numerics::turns::{sin_cos_pi, sin_squared_pi, within_half_turn};
use iridesce_numerics::{F32s, F64s, Number};
use iridesce_optics::film::kernel::{Fringes, free_absorbing, free_lossless, free_reflectance};
use iridesce_optics::mueller::Response;
use iridesce_optics::stack::layer::{Field, Turn};

/// Numbers of an answer.
const ANSWERS: usize = 34;
/// Numbers of a question.
const QUESTIONS: usize = 10;
/// Units of the last digit of 1 (2.2e-16 or 1.2e-7) by which instances may differ: some twenty roundings, of which those of
/// a phase of up to three half turns count 3 pi times, and twice that where fringes are steep.
const MOST_ULP: f64 = 60.0;

/// Everything that is asked of one instance. All inputs are of size 1.
#[inline(always)]
fn answers<V: Number>(x: [V; QUESTIONS]) -> [V; ANSWERS] {
    let [contrast, cos, per_b, n, loss, rate, length, cosh, sinh, q] = x;
    let mut out = [contrast; ANSWERS];
    let [s, p] = free_reflectance(contrast, cos, per_b);
    (out[0], out[1]) = (s, p);
    put(&mut out, 2, free_lossless(contrast, cos, per_b));
    put(&mut out, 10, free_absorbing(cos, [n, loss], [n * n * cos, loss], per_b, cosh - sinh));

    // A film between unlike media.
    let (y, sine_squared) = ([cos, n, q], sin_squared_pi(within_half_turn(rate, length)));
    let squares = [y[0] * y[0], y[1] * y[1], y[2] * y[2]];
    let of = |transmittance| [Fringes::new(squares, y, 0.5, transmittance); 2];
    (out[18], out[19]) = (Fringes::sum(&of(false), sine_squared), Fringes::sum(&of(true), sine_squared));
    out[20] = Fringes::sum(&[Fringes::new(squares, y, 1.0, false)], sine_squared);

    // A lossless layer on an absorbing one.
    let (sin, cosine) = sin_cos_pi(within_half_turn(rate, length));
    let turn = Turn::new(sin, cosine, cosh, sinh);
    let mut field = Field::leaving([q, loss]);
    field.up(turn.cos, [turn.sin[0] / n, turn.sin[1] / n], [turn.sin[0] * n, turn.sin[1] * n]);
    field.up_real(cosine, sin / q, sin * q);
    let (r, t) = field.amplitudes(cos);
    let numbers = [field.e[0], field.e[1], field.h[0], field.h[1], r[0], r[1], t[0], t[1], field.flux()];
    for (out, number) in out[21..].iter_mut().zip(numbers) {
        *out = number;
    }
    (out[30], out[31], out[32], out[33]) = (turn.cos[0], turn.cos[1], turn.sin[0], turn.sin[1]);
    out
}

#[inline(always)]
fn put<V: Number>(out: &mut [V; ANSWERS], at: usize, of: Response<V>) {
    for (place, m) in [(at, of.reflect), (at + 4, of.transmit)] {
        (out[place], out[place + 1], out[place + 2], out[place + 3]) = (m.s, m.p, m.cross[0], m.cross[1]);
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, x: &[f64; QUESTIONS]) -> [(&'static str, [f64; ANSWERS]); 4] {
    let single = x.map(|x| x as f32);
    [
        ("f64x8", answers(x.map(|x| f64x8::splat(simd, x))).map(|v| v.to_array()[6])),
        ("f64s", answers(x.map(|x| F64s::<S>::splat(simd, x))).map(|v| v.0[1])),
        ("f32x16", answers(single.map(|x| f32x16::splat(simd, x))).map(|v| f64::from(v.to_array()[13]))),
        ("f32s", answers(single.map(|x| F32s::<S>::splat(simd, x))).map(|v| f64::from(v.0[3]))),
    ]
}

fn at(level: Level, x: &[f64; QUESTIONS]) -> [(&'static str, [f64; ANSWERS]); 4] {
    dispatch!(level, simd => lanes(simd, x))
}

/// Random films, layers and directions, as numbers that single precision holds exactly.
fn question(random: &mut SplitMix64) -> [f64; QUESTIONS] {
    let mut between = |low: f64, high: f64| f64::from((low + (high - low) * random.unit()) as f32);
    let (half_turns, decay) = (between(0.0, 2.9), between(0.0, 2.0));
    let rate = between(0.5, 1.0);
    let exact = |value: f64| f64::from(value as f32);
    [
        between(0.2, 2.0),
        between(0.3, 1.0),
        between(0.1, 1.7),
        between(0.7, 1.6),
        between(0.05, 0.8),
        rate,
        exact(half_turns / rate),
        exact(0.5 * (1.0 + (-2.0 * decay).exp())),
        exact(-0.5 * (-2.0 * decay).exp_m1()),
        between(0.7, 1.6),
    ]
}

#[test]
fn every_instance_gives_the_same_film_and_the_same_layer() {
    let mut random = SplitMix64::new(9);
    let mut worst = [0.0_f64; 2];
    for _ in 0..2000 {
        let x = question(&mut random);
        let wanted = answers(x);
        for level in levels() {
            for (name, got) in at(level, &x) {
                let is_single = name.starts_with("f32");
                let unit = if is_single { f64::from(f32::EPSILON) } else { f64::EPSILON };
                for (place, (got, wanted)) in got.into_iter().zip(wanted).enumerate() {
                    let ulp = (got - wanted).abs() / (unit * wanted.abs().max(1.0));
                    worst[usize::from(is_single)] = worst[usize::from(is_single)].max(ulp);
                    assert!(
                        ulp <= MOST_ULP,
                        "{level:?} {name}, answer {place} of {x:?}: {got} for {wanted}: {ulp} ulp"
                    );
                }
            }
        }
    }
    println!("at most {worst:.1?} ulp of 1 (double, single)");
    // Levels that fuse products with sums round otherwise: instances that agreed to the bit would be one and the same.
    assert!(worst[0] > 0.0 && worst[1] > 0.0);
}

#[test]
fn the_scalar_instance_is_right() {
    // A free film of index 1.333, 300 nm, 550 nm, 45 degrees (Airy's sum, ten digits).
    let cos = std::f64::consts::FRAC_1_SQRT_2;
    let [s, p] = free_reflectance(1.333_f64 * 1.333 - 1.0, cos, 2.0 * 300.0 / 550.0);
    assert!((s - 0.0953222150).abs() < 1e-10 && (p - 0.0050102129).abs() < 1e-10, "{s} {p}");
    let all = free_lossless(1.333_f64 * 1.333 - 1.0, cos, 2.0 * 300.0 / 550.0);
    assert!((all.reflect.s - s).abs() < 1e-15 && (all.reflect.p - p).abs() < 1e-15);
    assert!((all.reflect.s + all.transmit.s - 1.0).abs() < 1e-15);
    // And by the complex form, which knows no special case.
    let b = (1.333_f64 * 1.333 - 0.5).sqrt();
    let complex = free_absorbing(cos, [b, 0.0], [1.333 * 1.333 * cos, 0.0], 2.0 * 300.0 / 550.0, 1.0);
    assert!((complex.reflect.s - s).abs() < 1e-14 && (complex.transmit.p + complex.reflect.p - 1.0).abs() < 1e-14);
    assert!((complex.reflect.cross[0] - all.reflect.cross[0]).abs() < 1e-14);
}
