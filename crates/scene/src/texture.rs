//! What files say of a surface at every place of it: pictures laid over shapes, and spectra.

use std::sync::Arc;

use iridesce_files::{Grid, Photograph, SpectrumChoice, read_spectrum};
use iridesce_optics::medium::VISIBLE_NM;
use iridesce_thickness::ThicknessMap;

use crate::model::{Object, Shape, UvMap};
use crate::shape::Chart;

/// Numbers laid over a shape by u and v: one at every place, or three.
#[derive(Debug, Clone)]
pub struct Texture {
    planes: Planes,
    chart: Chart,
    repeats: [bool; 2],
    /// It cannot be asked with a point of the world alone.
    needs_place: bool,
}

/// Grids of equal size, one a channel.
pub type Planes = Arc<[Arc<ThicknessMap>]>;

impl Texture {
    /// Lays grids over the shape of an object.
    pub(crate) fn new(planes: Planes, object: &Object) -> Texture {
        let chart = Chart::new(&object.shape);
        let is_mesh = matches!(object.shape, Shape::Mesh(_));
        let is_plain = !is_mesh && object.uv == UvMap::default();
        Texture {
            planes,
            repeats: if is_plain { chart.repeats() } else { [true; 2] },
            needs_place: !is_plain || !object.placement.is_plain(),
            chart,
        }
    }

    /// Whether a point of the world does not tell, since the object is moved, a mesh, or has a `uv` of its own:
    /// [`Texture::at_uv`] does.
    #[inline(always)]
    pub fn needs_place(&self) -> bool {
        self.needs_place
    }

    /// The numbers at a point of the shape, bilinear between texels; a grey texture has three equal ones.
    #[inline]
    pub fn at(&self, point: [f64; 3]) -> [f64; 3] {
        self.at_uv(self.chart.uv(point))
    }

    /// The same at u and v as maps are asked: those of the shape or the mesh, scaled and shifted.
    #[inline]
    pub fn at_uv(&self, [u, v]: [f64; 2]) -> [f64; 3] {
        match &self.planes[..] {
            [red, green, blue] => [red, green, blue].map(|plane| plane.sample_with(u, v, self.repeats)),
            planes => [planes[0].sample_with(u, v, self.repeats); 3],
        }
    }

    /// The means of the three numbers over all texels.
    pub fn mean(&self) -> [f64; 3] {
        let mean = |plane: &ThicknessMap| {
            let values = plane.thickness_nm();
            values.iter().sum::<f64>() / values.len() as f64
        };
        match &self.planes[..] {
            [red, green, blue] => [mean(red), mean(green), mean(blue)],
            planes => [mean(&planes[0]); 3],
        }
    }
}

/// What a matt surface reflects, as its file tells.
#[derive(Debug, Clone)]
pub enum ResolvedReflectance {
    /// Linear Rec.709 at every place.
    Map(Texture),
    /// Ascending wavelengths in nm, and reflectances.
    Spectrum(Arc<[(f64, f64)]>),
}

/// The roughness in a grid, 0 to 1, of which 0 means `min` and 1 `max`.
pub fn roughness_plane(grid: &Grid, min: f64, max: f64) -> Result<Planes, String> {
    // Whole numbers are shares of their format's range; floats stand as they are.
    let shares = grid.in_range(Some(0.0), Some(1.0)).or_else(|_| grid.in_range(None, None)).map_err(|e| e.rule())?;
    if let Some(at) = shares.thickness_nm().iter().position(|&value| value > 1.0) {
        let (row, column) = (at / shares.width(), at % shares.width());
        return Err(format!(
            "it holds {} at row {row}, column {column}; a roughness is a number from 0 to 1",
            shares.thickness_nm()[at]
        ));
    }
    let values = shares.thickness_nm().iter().map(|share| (max - min).mul_add(*share, min)).collect();
    let plane = ThicknessMap::new(shares.width(), shares.height(), values).map_err(|e| e.rule())?;
    Ok(Arc::new([Arc::new(plane)]))
}

/// The reflectance in a picture: linear Rec.709, 0 to 1.
pub fn reflectance_planes(picture: &Photograph) -> Result<Planes, String> {
    if let Some(at) = picture.rgb.iter().position(|&value| value > 1.0 + 1e-6) {
        let (row, column) = (at / 3 / picture.width, at / 3 % picture.width);
        return Err(format!(
            "it holds {} in {} at row {row}, column {column}; no surface reflects more than 1",
            picture.rgb[at],
            ["red", "green", "blue"][at % 3]
        ));
    }
    let mut planes = Vec::with_capacity(3);
    for channel in 0..3 {
        // A colour outside Rec.709 has a number below 0; a reflectance has none.
        let values = picture.rgb.iter().skip(channel).step_by(3).map(|&value| f64::from(value).clamp(0.0, 1.0));
        let plane = ThicknessMap::new(picture.width, picture.height, values.collect()).map_err(|e| e.rule())?;
        planes.push(Arc::new(plane));
    }
    Ok(planes.into())
}

/// The reflectance in a spectrometer's file.
pub fn reflectance_spectrum(bytes: &[u8]) -> Result<Arc<[(f64, f64)]>, String> {
    let choice = SpectrumChoice { quantity: "reflectance", range_nm: Some(VISIBLE_NM), ..SpectrumChoice::default() };
    let spectrum = read_spectrum(bytes, &choice)?;
    let mut pairs: Vec<(f64, f64)> = spectrum.wavelength_nm.iter().copied().zip(spectrum.values).collect();
    pairs.retain(|(_, value)| !value.is_nan());
    if pairs.len() < 2 {
        return Err("it holds fewer than two reflectances".to_owned());
    }
    if let Some((nm, value)) = pairs.iter().find(|(_, value)| !(0.0..=1.0).contains(value)) {
        return Err(format!("it holds {value} at {nm} nm; a reflectance is a number from 0 to 1"));
    }
    Ok(pairs.into())
}

/// A value of a table, linear between its entries; beyond its ends the last one holds.
///
/// ```
/// let table = [(400.0, 0.1), (500.0, 0.3)];
/// assert_eq!([380.0, 450.0, 700.0].map(|nm| iridesce_scene::held(&table, nm)), [0.1, 0.2, 0.3]);
/// ```
pub fn held(table: &[(f64, f64)], nm: f64) -> f64 {
    let above = table.partition_point(|(at, _)| *at < nm).clamp(1, table.len() - 1);
    let ((from, a), (to, b)) = (table[above - 1], table[above]);
    let share = ((nm - from) / (to - from)).clamp(0.0, 1.0);
    (b - a).mul_add(share, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::affine::Affine;
    use crate::model::{Placement, Reflectance, Roughness, Surface};

    fn object(shape: Shape) -> Object {
        Object {
            name: "plate".to_owned(),
            shape,
            surface: Surface::Diffuse(Reflectance::Rgb([0.5; 3])),
            roughness: Roughness::SMOOTH,
            placement: Placement::default(),
            uv: UvMap::default(),
            bump: None,
            priority: 0,
        }
    }

    /// An object that is moved, or has a `uv` of its own, is asked by u and v; with a `uv` pictures repeat.
    #[test]
    fn pictures_obey_transforms_and_uv() {
        let plane = Arc::new(ThicknessMap::new(2, 1, vec![0.0, 1.0]).unwrap());
        let planes: Planes = Arc::new([plane]);
        let shape = Shape::Rectangle { center: [0.0; 3], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0] };
        let mut plate = object(shape);
        let plain = Texture::new(planes.clone(), &plate);
        assert!(!plain.needs_place());
        assert_eq!((plain.at([0.9, 0.0, 0.0]), plain.at_uv([1.25, 0.5])), ([1.0; 3], [1.0; 3]), "it ends at its edge");
        plate.placement.transform = Affine::placed([1.0; 3], [0.0; 3], [5.0, 0.0, 0.0]);
        assert!(Texture::new(planes.clone(), &plate).needs_place());
        plate.placement = Placement::default();
        plate.uv.scale = [2.0, 1.0];
        let scaled = Texture::new(planes, &plate);
        assert!(scaled.needs_place());
        assert_eq!([0.25, 0.75, 1.25, 1.75].map(|u| scaled.at_uv([u, 0.5])[0]), [0.0, 1.0, 0.0, 1.0]);
    }

    #[test]
    fn spectra_are_read_as_ratios_and_refused_above_one() {
        let table = reflectance_spectrum(b"nm,R\n400,0.1\n500,0.3\n600,0.9\n").unwrap();
        assert_eq!(&table[..], [(400.0, 0.1), (500.0, 0.3), (600.0, 0.9)]);
        let why = reflectance_spectrum(b"nm,R\n400,0.1\n500,1.3\n600,0.9\n").unwrap_err();
        assert!(why.contains("1.3 at 500 nm"), "{why}");
    }

    #[test]
    fn pictures_become_reflectances() {
        let mut picture = Photograph {
            width: 2,
            height: 1,
            rgb: vec![0.25, -0.01, 1.0, 0.5, 0.5, 0.5],
            clipped: vec![false; 2],
            report: Default::default(),
        };
        let shape = Shape::Rectangle { center: [0.0; 3], u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0] };
        let texture = Texture::new(reflectance_planes(&picture).unwrap(), &object(shape));
        assert_eq!(texture.at([-0.75, 0.0, 0.0]), [0.25, 0.0, 1.0]);
        assert_eq!(texture.mean(), [0.375, 0.25, 0.75]);
        picture.rgb[4] = 1.5;
        assert!(reflectance_planes(&picture).unwrap_err().contains("1.5 in green at row 0, column 1"));
    }
}
