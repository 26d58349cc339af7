//! `tests/reference/colour_reference.json`: colours of films by an independent computation, on its own grid
//! (380..780 nm at 1 nm). XYZ there has Y = 100 for the perfect reflector.

use iridesce_optics::color::{
    Adaptation, ColorRequest, Dias1991, DiasMatrix, DiasTable, Grid, Illuminant, Model, Observer, Quantity, Space,
    StackColor, Weights,
};
use iridesce_optics::{Complex64, Medium, Polarization};
use serde_json::Value;

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/colour_reference.json")).unwrap()
}

fn triple(value: &Value) -> [f64; 3] {
    std::array::from_fn(|i| value[i].as_f64().unwrap())
}

fn grid() -> Grid {
    Grid { first_nm: 380.0, step_nm: 1.0, count: 401 }
}

fn constant(re: f64, im: f64) -> Medium {
    Medium::constant(Complex64::new(re, im)).unwrap()
}

/// First medium, film, last medium of a row.
fn media(system: &str) -> [Medium; 3] {
    let named = |name: &str| Medium::named(name).unwrap();
    match system {
        "soap_1.33" => [constant(1.0, 0.0), constant(1.33, 0.0), constant(1.0, 0.0)],
        "soap_1.40" => [constant(1.0, 0.0), constant(1.40, 0.0), constant(1.0, 0.0)],
        "air_gap_1.5" => [constant(1.5, 0.0), constant(1.0, 0.0), constant(1.5, 0.0)],
        "const_film_2.4_on_2.7+3.8i" => [constant(1.0, 0.0), constant(2.4, 0.0), constant(2.7, 3.8)],
        "SiO2_on_Si" => [named("air"), named("SiO2"), named("Si")],
        "TiO2_on_Ti" => [named("air"), named("TiO2-siefke"), named("Ti")],
        other => panic!("unknown system {other}"),
    }
}

/// Worst differences of XYZ (Y = 1), xy, Lab, linear sRGB, adapted linear sRGB over the rows that `wanted` picks; their number.
fn worst(wanted: impl Fn(&str) -> bool) -> ([f64; 5], usize) {
    let (file, mut worst, mut points) = (reference(), [0.0f64; 5], 0);
    for row in file["rows"].as_array().unwrap() {
        let system = row["system"].as_str().unwrap();
        if !wanted(system) {
            continue;
        }
        let thickness: Vec<f64> = row["d_nm"].as_array().unwrap().iter().map(|t| t.as_f64().unwrap()).collect();
        let angle = vec![row["angle_deg"].as_f64().unwrap(); thickness.len()];
        let colors = |space: Space, adaptation: Adaptation| {
            let request = ColorRequest {
                media: media(system).to_vec(),
                coherent: vec![true],
                illuminant: Illuminant::named(row["illuminant"].as_str().unwrap()).unwrap(),
                observer: Observer::Cie1931,
                polarization: Polarization::Unpolarized,
                quantity: Quantity::Reflectance,
                model: if row["model"] == "dias1991" { Model::TwoBeam } else { Model::Exact },
                grid: Some(grid()),
                space,
                adaptation,
                gamut: None,
            };
            StackColor::new(request).unwrap().colors(&thickness, &angle).unwrap().values
        };
        for (what, (space, adaptation, key, channels, scale)) in [
            (Space::Xyz, Adaptation::None, "XYZ", 3, 100.0),
            (Space::Xyy, Adaptation::None, "xy", 2, 1.0),
            (Space::Lab, Adaptation::None, "Lab", 3, 1.0),
            (Space::LinearSrgb, Adaptation::None, "sRGB_linear", 3, 1.0),
            (Space::LinearSrgb, Adaptation::Bradford, "sRGB_linear_bradford", 3, 1.0),
        ]
        .into_iter()
        .enumerate()
        {
            for (value, stated) in colors(space, adaptation).iter().zip(row[key].as_array().unwrap()) {
                for i in 0..channels {
                    worst[what] = worst[what].max((value[i] - stated[i].as_f64().unwrap() / scale).abs());
                }
            }
        }
        points += thickness.len();
    }
    (worst, points)
}

fn figures(worst: [f64; 5]) -> String {
    worst.map(|w| format!("{w:.1e}")).join(" ")
}

#[test]
fn whites() {
    for (name, white) in reference()["whites"].as_object().unwrap() {
        let made = Weights::new(&grid(), &Illuminant::named(name).unwrap(), Observer::Cie1931).unwrap().white;
        for (value, stated) in made.iter().zip(triple(white)) {
            assert!((value - stated / 100.0).abs() < 1e-11, "{name}: {made:?}");
        }
    }
}

#[test]
fn films_of_constant_index() {
    let (worst, points) = worst(|system| !["SiO2_on_Si", "TiO2_on_Ti"].contains(&system));
    println!("constant index, {points} colours, worst of XYZ xy Lab sRGB sRGB-bradford: {}", figures(worst));
    assert_eq!(points, 1380);
    assert!(worst.iter().all(|&w| w < 1e-6), "{worst:?}");
}

#[test]
fn films_of_built_in_media() {
    let (worst, points) = worst(|system| ["SiO2_on_Si", "TiO2_on_Ti"].contains(&system));
    println!("built-in media, {points} colours, worst of XYZ xy Lab sRGB sRGB-bradford: {}", figures(worst));
    assert_eq!(points, 256);
    assert!(worst.iter().all(|&w| w < 1e-6), "{worst:?}");
}

#[test]
fn coarse_seed() {
    let file = reference();
    let seed = &file["coarse_seed"];
    let matrix = std::array::from_fn(|i| triple(&seed["matrix"][i]));
    let mut points = 0;
    for row in seed["rows"].as_array().unwrap() {
        let n: [Complex64; 3] = match row["system"].as_str().unwrap() {
            "soap_1.33" => [1.0, 1.33, 1.0].map(Complex64::from),
            "soap_1.40" => [1.0, 1.40, 1.0].map(Complex64::from),
            "air_gap_1.5" => [1.5, 1.0, 1.5].map(Complex64::from),
            other => panic!("unknown system {other}"),
        };
        let film = Dias1991::new(&[n; 40], DiasTable::Full, DiasMatrix::Given(matrix)).unwrap();
        for (i, t) in row["d_nm"].as_array().unwrap().iter().enumerate() {
            let (xyz, rgb) = film.color(t.as_f64().unwrap(), row["angle_deg"].as_f64().unwrap()).unwrap();
            for (value, stated) in [(xyz, triple(&row["XYZ"][i])), (rgb, triple(&row["NTSC_linear"][i]))] {
                for c in 0..3 {
                    assert!((value[c] - stated[c]).abs() < 1e-6, "{row:?} {t}: {value:?}");
                }
            }
            points += 1;
        }
    }
    assert!(points >= 30, "{points}");
}
