//! Times the bench bubble and prints its furnace error: `cargo run --release --example bench_bubble -- SAMPLES THREADS`.

use iridesce_render::{RenderOptions, render};
use iridesce_scene::{Node, Origin, Scene};

const BUBBLE: &str = r#"
version = 1
camera = { position = [0, 0, 4], target = [0, 0, 0], fov_deg = 35.0, resolution = [512, 512] }
object = [{ name = "bubble", shape = { sphere = { radius = 1.0 } }, surface = { film = { medium = 1.33, thickness_nm = { gradient = { top = 0, bottom = 800 } } } } }]
"#;

fn main() {
    let number = |at: usize| std::env::args().nth(at).and_then(|a| a.parse::<u32>().ok());
    let options = RenderOptions { samples: number(1), threads: number(2).map(|t| t as usize), ..Default::default() };
    for light in [r#"illuminant = "D65""#, r#"builtin = "studio""#] {
        let text = format!("{BUBBLE}light = [{{ environment = {{ {light} }} }}]");
        let tree = Node::from_toml(&text).expect("the scene is TOML");
        let scene = Scene::from_node(&tree, Origin::default()).expect("the scene is sound");
        let frame = render(&scene, &options, &()).expect("the scene renders");
        let worst = frame.xyz.chunks(3).map(|p| (p[1] - 1.0).abs()).fold(0.0, f32::max);
        println!("{light}: {:?}, worst |Y - 1| {worst:.1e}", frame.info);
    }
}
