use fearless_simd::Level;
use iridesce_numerics::lanes::SINGLES as LANES;
use iridesce_numerics::{Vec3, Watch};
use iridesce_optics::stack::solve;
use iridesce_optics::{Complex64, Polarization};
use iridesce_scene::{Context, Origin, ResolvedScene, Scene, resolve};

use super::path::Target;
use super::*;
use crate::framebuffer::RenderOptions;
use crate::geometry::Hit;
use crate::medium_stack::MediumStack;
use crate::prepare::Prepared;
use crate::spectral::Nodes;

const THICKNESS_NM: f64 = 310.0;

fn scene(index: Complex64) -> ResolvedScene {
    let text = format!(
        "version = 1\n[camera]\n[[object]]\nshape = {{ sphere = {{ radius = 1.0 }} }}\n\
         surface = {{ film = {{ medium = [{}, {}], thickness_nm = {THICKNESS_NM} }} }}\n\
         [[light]]\nenvironment = {{ illuminant = \"D65\" }}\n",
        index.re, index.im
    );
    let recipe = Scene::from_toml(&text, Origin::default()).unwrap();
    resolve(&recipe, &Context::default(), &Watch::new()).unwrap()
}

/// A film plate that a path meets: at this angle, its plane of incidence turned by `turn` from the p direction
/// of the path's frame, and mirrored or passed.
#[derive(Clone, Copy)]
struct Plate {
    angle: f64,
    turn: f64,
    mirrored: bool,
}

/// Sends a path over plates; gives its s + p weights by node, and the turns (cos, sin) between planes.
fn over_plates(index: Complex64, plates: &[Plate]) -> (Vec<f64>, Vec<[f64; 2]>) {
    #[inline(always)]
    fn run<S: Simd>(simd: S, prepared: &Prepared, plates: &[Plate], turns: &mut Vec<[f64; 2]>) -> Vec<f64> {
        let mut tracer = Tracer::new(prepared, 0);
        tracer.arena.fill(Lanes::ONE);
        let direction = Vec3::new(0.3, -0.5, -0.8).normalized();
        let mut path = Path {
            direction,
            hit: Hit::on(0, Vec3::default(), direction),
            axis: frame(direction).0,
            slot: 0,
            hits: 0,
            medium: MediumStack::default(),
            floor: 0.0,
            is_whole: true,
            is_sparse: false,
            lot: Lot::SINGLE,
            in_plane: true,
            is_unpolarized: true,
            band: None,
            since: Since::Bend,
            chain: Chain::UNTOLD,
        };
        for plate in plates {
            let light = -path.direction;
            let p_axis = light.cross(path.axis);
            let (sin, cos) = plate.turn.sin_cos();
            let across = p_axis * cos + path.axis * sin;
            let (sin, cos) = plate.angle.sin_cos();
            path.hit.normal = across * sin - path.direction * cos;
            let before = path.axis;
            tracer.rotate_stokes_frame(simd, &mut path);
            turns.push([path.axis.dot(before), path.axis.dot(light.cross(before))]);
            path.hits += 1;
            path.is_unpolarized = false;
            let mut sums = Sums([f32x16::splat(simd, 0.0); 3]);
            let (kept, other) = (path.slot, 1 - path.slot);
            let to = if plate.mirrored { [other, kept] } else { [kept, other] };
            let cos_theta = plate.angle.cos() as f32;
            let targets = [Target::Slot(to[0]), Target::Slot(to[1])];
            tracer.split_film(simd, &path, 0, cos_theta, THICKNESS_NM as f32, targets, &mut sums);
            path.slot = other;
            if plate.mirrored {
                let along = path.direction.dot(path.hit.normal);
                path.direction = path.direction - path.hit.normal * (2.0 * along);
            }
        }
        (0..tracer.blocks)
            .flat_map(|block| {
                let s = tracer.arena[tracer.at(path.slot, 0, block)].0;
                let p = tracer.arena[tracer.at(path.slot, 1, block)].0;
                (0..LANES).map(move |lane| 0.5 * f64::from(s[lane] + p[lane]))
            })
            .collect()
    }
    let scene = scene(index);
    let prepared = Prepared::new(&scene, &RenderOptions::default()).unwrap();
    let mut turns = Vec::new();
    let carried = at_level!(Level::new(), simd => run(simd, &prepared, plates, &mut turns));
    (carried, turns)
}

fn amplitudes(index: Complex64, nm: f64, plate: Plate) -> [Complex64; 2] {
    [Polarization::S, Polarization::P].map(|polarization| {
        let one = Complex64::new(1.0, 0.0);
        let media = [one, index, one];
        let solved = solve(&media, &[THICKNESS_NM], &[true], nm, plate.angle.cos(), polarization).unwrap();
        let amplitudes = solved.amplitudes.unwrap();
        if plate.mirrored { amplitudes.r } else { amplitudes.t }
    })
}

/// Two plates by Mueller algebra: for unpolarised light and an eye that sees no polarisation,
/// I = a1 a2 + b1 b2 cos(2 turn), a = (R_s + R_p) / 2, b = (R_s - R_p) / 2.
#[test]
fn two_plates_by_mueller_algebra() {
    let index = Complex64::new(1.33, 0.0);
    let nodes = Nodes::new(32, &[]);
    for turn_deg in [0.0_f64, 30.0, 45.0, 90.0, 137.0] {
        // `turn` is measured between p directions, so the s directions differ by as much.
        let first = Plate { angle: 55_f64.to_radians(), turn: 0.7, mirrored: true };
        let second = Plate { angle: 48_f64.to_radians(), turn: turn_deg.to_radians(), mirrored: true };
        let (carried, turns) = over_plates(index, &[first, second]);
        let cos2 = (2.0 * turn_deg.to_radians()).cos();
        assert!((turns[1][0].powi(2) - turns[1][1].powi(2) - cos2).abs() < 1e-12);
        for (i, &nm) in nodes.wavelength_nm.iter().enumerate() {
            let halves = |plate| {
                let [s, p] = amplitudes(index, nm, plate).map(|z| z.norm_sqr());
                [0.5 * (s + p), 0.5 * (s - p)]
            };
            let ([a1, b1], [a2, b2]) = (halves(first), halves(second));
            let expected = a1 * a2 + b1 * b2 * cos2;
            // R is good to 3e-6 (film.rs); two of them multiply to R^2 <= 0.1.
            assert!((carried[i] - expected).abs() < 2e-6, "{turn_deg} deg, {nm} nm: {} {expected}", carried[i]);
        }
    }
}

/// Four plates against fields: E over every plate and turn by complex 2 x 2 matrices, whose mean square over two
/// crossed fields is the light of an unpolarised source. Here all four Stokes components take part.
#[test]
fn four_plates_by_jones_algebra() {
    let nodes = Nodes::new(32, &[]);
    for index in [Complex64::new(1.33, 0.0), Complex64::new(1.9, 0.4)] {
        let plate = |angle: f64, turn: f64, mirrored| Plate { angle: angle.to_radians(), turn, mirrored };
        let plates = [plate(60.0, 0.2, true), plate(50.0, 0.6, false), plate(65.0, -1.1, true), plate(40.0, 0.8, true)];
        let (carried, turns) = over_plates(index, &plates);
        for (i, &nm) in nodes.wavelength_nm.iter().enumerate() {
            // Light meets the last plate first: the product of (plate, turn to the next one in) from the eye on.
            let mut total = [[Complex64::new(1.0, 0.0), Complex64::ZERO], [Complex64::ZERO, Complex64::new(1.0, 0.0)]];
            for (plate, [c, s]) in plates.iter().zip(&turns) {
                for row in &mut total {
                    let turned = [row[0] * c + row[1] * s, row[1] * c - row[0] * s];
                    let [a_s, a_p] = amplitudes(index, nm, *plate);
                    *row = [turned[0] * a_s, turned[1] * a_p];
                }
            }
            let expected = 0.5 * total.iter().flatten().map(|z| z.norm_sqr()).sum::<f64>();
            assert!((carried[i] - expected).abs() < 2e-6, "{index}, {nm} nm: {} {expected}", carried[i]);
        }
    }
}

/// Caustics are looked for where a small lamp, something that bends its light and something that scatters it are together;
/// other scenes are drawn as if there were no caustics at all.
#[test]
fn caustics_are_looked_for_where_they_may_be() {
    let floor = "[[object]]\nshape = { plane = {} }\nsurface = { diffuse = { reflectance = 0.5 } }\n";
    let black = "[[object]]\nshape = { plane = {} }\nsurface = { diffuse = { reflectance = 0.0 } }\n";
    let ball = "[[object]]\nshape = { sphere = { center = [0, 1, 0], radius = 0.5 } }\nsurface = { dielectric = { medium = 1.5 } }\n";
    let rough = "[[object]]\nshape = { sphere = { center = [0, 1, 0], radius = 0.5 } }\nsurface = { dielectric = { medium = 1.5, roughness = 0.3 } }\n";
    let lamp = |radius: f64| {
        format!(
            "[[object]]\nshape = {{ sphere = {{ center = [0, 4, 0], radius = {radius} }} }}\nsurface = {{ emitter = {{ radiance = 1.0 }} }}\n"
        )
    };
    let looks = |objects: &[&str], light: &str| {
        let text = format!("version = 1\n[camera]\n{}{light}", objects.concat());
        let recipe = Scene::from_toml(&text, Origin::default()).unwrap();
        let scene = resolve(&recipe, &Context::default(), &Watch::new()).unwrap();
        crate::caustics::seeds(&Prepared::new(&scene, &RenderOptions::default()).unwrap()).is_some()
    };
    let (small, large) = (lamp(0.01), lamp(1.0));
    let dark = "[[light]]\nenvironment = { illuminant = \"D65\", radiance = 0.0 }\n";
    let point = "[[light]]\npoint = { position = [0, 4, 0] }\n";
    assert!(looks(&[floor, ball, &small], dark) && looks(&[floor, ball], point));
    assert!(!looks(&[floor, ball, &large], dark) && !looks(&[floor, &small], dark) && !looks(&[floor, ball], dark));
    assert!(
        !looks(&[ball, &small], dark) && !looks(&[black, ball, &small], dark) && !looks(&[floor, rough, &small], dark)
    );
}

/// What is known ahead of an emitter is what a path to it finds, to the last bit; where a path would find something else, it is not told.
#[test]
fn emitters_seen_straight_are_what_paths_find() {
    #[inline(always)]
    fn run<S: Simd>(simd: S, prepared: &Prepared) -> (bool, [[f64; 4]; 2]) {
        let ray = prepared.camera.ray(40.0, 30.0);
        let hit = prepared.geometry.nearest(&ray, None).unwrap();
        let [mut known, mut traced] = [(); 2].map(|()| Tracer::new(prepared, 0));
        let mut is_known = true;
        for sample in 0..3 {
            is_known &= known.sees_emitter(simd, &ray, hit.object);
            let mut choices = crate::sampler::PixelSampler::new(1, 1).choices(sample);
            assert!(traced.trace(simd, ray, Some(hit), &mut choices));
        }
        assert!(traced.has_met_surface() && known.has_met_surface() == is_known);
        (is_known, [known.take_batch(0), traced.take_batch(0)])
    }
    let seen = |camera: &str, more: &str, options: RenderOptions| {
        let text = format!(
            "version = 1\n[camera]\nresolution = [80, 60]\n{camera}\n[[object]]\nshape = {{ sphere = {{ radius = 1.0 }} }}\n\
             surface = {{ emitter = {{ illuminant = \"A\", radiance = 1.7 }} }}\n\
             [[light]]\nenvironment = {{ illuminant = \"E\", radiance = 0.0 }}\n{more}"
        );
        let recipe = Scene::from_toml(&text, Origin::default()).unwrap();
        let scene = resolve(&recipe, &Context::default(), &Watch::new()).unwrap();
        let prepared = Prepared::new(&scene, &options).unwrap();
        at_level!(Level::new(), simd => run(simd, &prepared))
    };
    let lens = "aperture_radius = 0.1\nfocus_distance = 4.0";
    for camera in ["", lens] {
        let (is_known, [known, traced]) = seen(camera, "", RenderOptions::default());
        assert!(is_known && traced[1] > 1.0);
        assert_eq!(known, traced);
    }
    let smoke =
        "[[object]]\nshape = { sphere = { radius = 100.0 } }\nsurface = { dielectric = { medium = [1.0, 1e-10] } }\n";
    let stokes = RenderOptions { stokes: true, ..RenderOptions::default() };
    for (camera, more, options) in [
        ("polarizer_deg = 30.0", "", RenderOptions::default()),
        ("", smoke, RenderOptions::default()),
        ("", "", stokes),
    ] {
        let (is_known, [known, traced]) = seen(camera, more, options);
        assert!(!is_known && known == [0.0; 4] && traced[1] > 0.0);
    }
}
