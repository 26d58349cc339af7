//! Times the bench bubble (512 x 512) and prints its furnace error: `cargo run --release --example bench_bubble -- 64`.
use std::sync::Arc;

use iridesce_optics::color::Illuminant;
use iridesce_optics::{Complex64, Medium};
use iridesce_render::{RenderOptions, render};
use iridesce_scene::*;
use iridesce_thickness::ThicknessModel;

fn main() {
    let samples: u32 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(16);
    let threads: Option<usize> = std::env::args().nth(2).and_then(|a| a.parse().ok());
    let rgb = (0..512 * 1024)
        .flat_map(|i| {
            let v = 0.05 + 0.2 * (i / 1024) as f32 / 512.0;
            [v * 0.92, v, v * 1.12]
        })
        .collect();
    let map = Arc::new(EnvironmentMap { width: 1024, height: 512, rgb });
    for (name, source) in [
        ("furnace", EnvironmentSource::Uniform(Illuminant::named("D65").unwrap())),
        ("map", EnvironmentSource::Map(map)),
    ] {
        let scene = Scene {
            unit: Unit::Cm,
            camera: Camera {
                position: [0.0, 0.0, 4.0],
                target: [0.0; 3],
                up: [0.0, 1.0, 0.0],
                projection: Projection::Perspective { fov_deg: 35.0 },
                resolution: [512, 512],
            },
            render: RenderSettings { samples, seed: 1, max_depth: 16 },
            objects: vec![Object {
                name: "bubble".into(),
                shape: Shape::Sphere { center: [0.0; 3], radius: 1.0 },
                surface: Surface::Film(Film {
                    medium: Medium::constant(Complex64::new(1.33, 0.0)).unwrap(),
                    thickness: ThicknessModel::Gradient { top_nm: 0.0, bottom_nm: 800.0, exponent: 1.0 },
                    outside: Medium::named("air").unwrap(),
                }),
            }],
            lights: vec![Light::Environment(Environment { source, rotation_deg: 0.0, radiance: 1.0 })],
        };
        let frame = render(&scene, &RenderOptions { threads, ..Default::default() }, &()).unwrap();
        let worst = frame.xyz.chunks(3).map(|p| (p[1] - 1.0).abs()).fold(0.0, f32::max);
        let mean: f32 = frame.xyz.chunks(3).map(|p| p[1]).sum::<f32>() / (512.0 * 512.0);
        println!("{name}: {:?} worst |Y - 1| {worst:.2e}, mean {mean:.5}", frame.info);
    }
}
