use iridesce_thickness::flow::*;
use std::io::Write;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let p = Parameters::preset(&a[1]).unwrap();
    let p = if a.len() > 4 { p.with_columns(a[4].parse().unwrap()) } else { p };
    let mut film = Film::new(p).unwrap();
    let (rows, cols) = (film.parameters().rows, film.parameters().columns);
    let mut k = 0;
    let start = std::time::Instant::now();
    for t in a[2].split(',') {
        let t: f64 = t.parse().unwrap();
        if let Err(e) = film.advance_to(t) {
            println!("{e}");
            return;
        }
        let h = film.thickness_nm();
        let s = film.state();
        let vmax = s.down.iter().chain(&s.across).fold(0.0f64, |m, v| m.max(v.abs()));
        println!(
            "t {t} mean {:.2} min {:.2} max {:.2} vmax {vmax:.3} effort {:?} err {:e} books {:?} ms/step {:.1} s {:e}",
            h.iter().sum::<f64>() / h.len() as f64,
            h.iter().copied().fold(1e9, f64::min),
            h.iter().copied().fold(0.0, f64::max),
            film.effort(),
            (film.volume() + s.books.gone()) / s.books.start - 1.0,
            s.books,
            start.elapsed().as_secs_f64() * 1e3 / s.step as f64,
            film.surfactant()
        );
        let mut f = std::fs::File::create(format!("{}_{k}_{cols}x{rows}.f64", a[3])).unwrap();
        for v in h {
            f.write_all(&v.to_le_bytes()).unwrap();
        }
        k += 1;
    }
}
