//! Colours, spectra and the tables behind them.

use iridesce_numerics::Watch;
use iridesce_optics::color::{
    Adaptation, ColorRequest, ColorTable, ColorTableRequest, FIRST_NM, Illuminant, LAST_NM, Model, Observer, Quantity,
    Space, StackColor, ciede2000,
    gamut::{Gamut, Mapping},
    illuminant_names,
};
use iridesce_optics::stack::StackText;
use iridesce_optics::stack::sweep::{Operand, Quantity as Asked, Sweep, SweepRequest};
use iridesce_optics::{Beyond, Layer, Medium, OpticsError, Polarization, Stack, medium};

use crate::face::Face;

/// Most numbers of one call, either way: 128 MiB.
const MOST_NUMBERS: usize = 1 << 24;

/// The stack itself; an open layer is 0 nm thick.
fn stack_of(read: &StackText) -> Stack {
    let layers = (0..read.thickness_nm.len())
        .map(|i| Layer {
            medium: read.media[i + 1].clone(),
            thickness_nm: read.thickness_nm[i],
            coherent: read.coherent[i],
        })
        .collect();
    Stack { first: read.media[0].clone(), layers, last: read.media[read.media.len() - 1].clone() }
}

fn words(error: OpticsError) -> String {
    error.to_string()
}

fn check_count(count: usize, what: &str) -> Result<(), String> {
    if count <= MOST_NUMBERS { Ok(()) } else { Err(format!("at most {MOST_NUMBERS} {what} at once, got {count}")) }
}

/// An empty word takes the default.
fn or<'a>(word: &'a str, default: &'a str) -> &'a str {
    if word.is_empty() { default } else { word }
}

/// Text: a stack. Message: a line an item: name, nm or `?`, `coherent` or `incoherent` or nothing for the two ends,
/// the range of its data in nm (empty: everywhere).
pub fn describe(face: &mut Face) -> Result<(), String> {
    let [stack] = face.lines()?;
    let read = StackText::parse(&stack).map_err(words)?;
    let last = read.media.len() - 1;
    for (place, medium) in read.media.iter().enumerate() {
        let layer = place.wrapping_sub(1);
        let (nm, kind) = match place {
            _ if place == 0 || place == last => (String::new(), ""),
            _ => {
                let nm = if read.open[layer] { "?".to_owned() } else { read.thickness_nm[layer].to_string() };
                (nm, if read.coherent[layer] { "coherent" } else { "incoherent" })
            }
        };
        let range = medium.range_nm().map_or(String::new(), |(from, to)| format!("{from}\t{to}"));
        face.message.push_str(&format!("{}\t{nm}\t{kind}\t{range}\n", medium.name()));
    }
    Ok(())
}

/// Message: a line a built-in medium: name, kind, source.
pub fn media(face: &mut Face) -> Result<(), String> {
    for name in medium::names() {
        let medium = Medium::named(name).map_err(words)?;
        face.message.push_str(&format!("{name}\t{}\t{}\n", medium.kind().word(), medium.source()));
    }
    Ok(())
}

/// Message: a line a built-in illuminant.
pub fn illuminants(face: &mut Face) -> Result<(), String> {
    face.message = illuminant_names().collect::<Vec<_>>().join("\n");
    Ok(())
}

/// Text: stack, illuminant, quantity, model, polarization, a line each. Numbers: which layer varies (counted from 0; -1:
/// none), then thickness and angle of each point. Result: X, Y, Z of each point.
pub fn color(face: &mut Face) -> Result<(), String> {
    let [stack, illuminant, quantity, model, polarization] = face.lines()?;
    let read = StackText::parse(&stack).map_err(words)?;
    let numbers = std::mem::take(&mut face.numbers);
    let [layer, points @ ..] = numbers.as_slice() else {
        return Err("a colour needs a layer and points".to_owned());
    };
    let (points, rest) = points.as_chunks::<2>();
    let layers = read.thickness_nm.len();
    check_count(points.len().saturating_mul(layers.max(3)), "thicknesses and colours")?;
    if !rest.is_empty() || !(*layer == -1.0 || (*layer >= 0.0 && *layer < layers as f64 && layer.fract() == 0.0)) {
        return Err(format!("a stack of {layers} layers and points of two numbers do not go with layer {layer}"));
    }
    let mut thickness = Vec::with_capacity(points.len() * layers);
    let mut angle = Vec::with_capacity(points.len());
    for [nm, deg] in points {
        let first = thickness.len();
        thickness.extend_from_slice(&read.thickness_nm);
        if *layer >= 0.0 {
            thickness[first + *layer as usize] = *nm;
        }
        angle.push(*deg);
    }
    let key = format!("{stack}\n{illuminant}\n{quantity}\n{model}\n{polarization}");
    let sums = face.color(&key, || {
        StackColor::new(request(&read, &illuminant, &quantity, &model, &polarization)?).map_err(words)
    })?;
    let colors = sums.colors(&thickness, &angle).map_err(words)?;
    face.result = colors.values.as_flattened().to_vec();
    Ok(())
}

fn request(
    read: &StackText,
    illuminant: &str,
    quantity: &str,
    model: &str,
    polarization: &str,
) -> Result<ColorRequest, String> {
    Ok(ColorRequest {
        media: read.media.clone(),
        coherent: read.coherent.clone(),
        illuminant: Illuminant::named(or(illuminant, "D65")).map_err(words)?,
        observer: Observer::Cie1931,
        polarization: Polarization::named(or(polarization, "unpolarized")).map_err(words)?,
        quantity: Quantity::named(or(quantity, "reflectance")).map_err(words)?,
        model: Model::named(or(model, "exact")).map_err(words)?,
        grid: None,
        space: Space::Xyz,
        adaptation: Adaptation::None,
        gamut: None,
    })
}

/// Text: stack, illuminant, quantity, an empty line, polarization. Numbers: which layer varies, range in nm, range in
/// degrees, the greatest CIEDE2000 allowed. Result: rows, columns, first reduced thickness and step in nm, first angle and
/// step in degrees, 1/m^2 of the reduced thickness, X, Y, Z of the white, greatest and mean CIEDE2000 reached; then the nodes,
/// row by row: X, Y, Z and their slopes a step.
pub fn table(face: &mut Face) -> Result<(), String> {
    let [stack, illuminant, quantity, _, polarization] = face.lines()?;
    let read = StackText::parse(&stack).map_err(words)?;
    let [layer, from_nm, to_nm, from_deg, to_deg, tolerance] = face.numbers[..] else {
        return Err("a table takes a layer, a range in nm, one in degrees and a tolerance".to_owned());
    };
    if !(layer >= 0.0 && layer < read.thickness_nm.len() as f64 && layer.fract() == 0.0) {
        return Err(format!("a stack of {} layers has no layer {layer}", read.thickness_nm.len()));
    }
    let color = request(&read, &illuminant, &quantity, "", &polarization)?;
    let thickness_nm = read.thickness_nm;
    let (range_nm, range_deg) = ([from_nm, to_nm], [from_deg, to_deg]);
    let asked = ColorTableRequest { color, thickness_nm, layer: layer as usize, range_nm, range_deg, tolerance };
    // Nobody else runs here: what takes too long is stopped by ending the worker.
    let table = ColorTable::build(asked, &Watch::new()).map_err(words)?;
    let shape = table.shape();
    let first = table.reduced_nm(0);
    let rows = shape.rows;
    let angle_step = if rows == 1 { 1.0 } else { (to_deg - from_deg) / (rows - 1) as f64 };
    face.result = vec![
        rows as f64,
        shape.columns as f64,
        first,
        table.reduced_nm(1) - first,
        from_deg,
        angle_step,
        shape.inverse_square,
    ];
    face.result.extend(shape.white);
    face.result.extend([shape.max_delta_e, shape.mean_delta_e]);
    face.result.extend(table.nodes().iter().flat_map(|n| [n[0], n[1], n[2], n[4], n[5], n[6]].map(f64::from)));
    Ok(())
}

/// Text: stack, quantity, polarization, model. Numbers: the angle in degrees, then wavelengths in nm. Result: a power ratio
/// a wavelength.
pub fn spectrum(face: &mut Face) -> Result<(), String> {
    let [stack, quantity, polarization, model] = face.lines()?;
    let read = StackText::parse(&stack).map_err(words)?;
    let quantity = Quantity::named(or(&quantity, "reflectance")).map_err(words)?;
    let polarization = Polarization::named(or(&polarization, "unpolarized")).map_err(words)?;
    let model = Model::named(or(&model, "exact")).map_err(words)?;
    let numbers = std::mem::take(&mut face.numbers);
    let [angle, wavelengths @ ..] = numbers.as_slice() else {
        return Err("a spectrum needs an angle and wavelengths".to_owned());
    };
    check_count(wavelengths.len(), "wavelengths")?;
    let stack = stack_of(&read);
    let asked = if model == Model::TwoBeam { Asked::TwoBeam } else { Asked::Power(quantity) };
    face.result = swept(&stack, *angle, wavelengths, asked, polarization)?;
    Ok(())
}

/// The spectrum by the sweep that every other face of this program asks too, so that all agree to the last digits.
fn swept(
    stack: &Stack,
    angle_deg: f64,
    wavelength_nm: &[f64],
    quantity: Asked,
    polarization: Polarization,
) -> Result<Vec<f64>, String> {
    let mut tables = vec![Vec::with_capacity(wavelength_nm.len()); stack.layers.len() + 2];
    for &nm in wavelength_nm {
        if !(nm > 0.0 && nm.is_finite()) {
            return Err(format!("wavelength_nm must be > 0 and finite, got {nm}"));
        }
        for (table, index) in tables.iter_mut().zip(stack.indices(nm).map_err(words)?) {
            table.push(index);
        }
    }
    let thickness: Vec<[f64; 1]> = stack.layers.iter().map(|layer| [layer.thickness_nm]).collect();
    let angle = [angle_deg];
    let sweep = Sweep::new(SweepRequest {
        quantity,
        polarization,
        indices: tables.iter().map(Vec::as_slice).collect(),
        coherent: stack.layers.iter().map(|layer| layer.coherent).collect(),
        shape: vec![wavelength_nm.len()],
        wavelength_nm: Operand { values: wavelength_nm, strides: vec![1] },
        angle_deg: Operand { values: &angle, strides: vec![0] },
        thickness_nm: thickness.iter().map(|values| Operand { values, strides: vec![0] }).collect(),
    });
    let mut values = vec![0.0; wavelength_nm.len()];
    sweep.map_err(words)?.evaluate(&mut values).map_err(words)?;
    Ok(values)
}

/// X, Y, Z of the light, Y = 1.
fn relative_white(light: &Illuminant) -> [f64; 3] {
    let white = light.white(Observer::Cie1931);
    white.map(|value| value / white[1])
}

/// Text: from, to, the illuminant whose white is meant, gamut mapping or nothing. Numbers: triples. Result: triples.
pub fn convert(face: &mut Face) -> Result<(), String> {
    let [from, to, illuminant, mapping] = face.lines()?;
    let (from, to) = (Space::named(&from).map_err(words)?, Space::named(&to).map_err(words)?);
    let white = relative_white(&Illuminant::named(or(&illuminant, "D65")).map_err(words)?);
    let gamut = match mapping.as_str() {
        "" => None,
        name => Gamut::new(to, Mapping::named(name).map_err(words)?),
    };
    let (triples, rest) = face.numbers.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(format!("colours are triples, got {} numbers", face.numbers.len()));
    }
    face.result = triples
        .iter()
        .flat_map(|&triple| {
            let value = to.from_xyz(from.to_xyz(triple, white, Adaptation::None), white, Adaptation::None);
            gamut.as_ref().map_or(value, |gamut| gamut.map_encoded(to, value).0)
        })
        .collect();
    Ok(())
}

/// Numbers: two Lab colours a pair. Result: CIEDE2000 of each.
pub fn delta_e(face: &mut Face) -> Result<(), String> {
    let (pairs, rest) = face.numbers.as_chunks::<6>();
    if !rest.is_empty() {
        return Err(format!("differences take pairs of Lab, got {} numbers", face.numbers.len()));
    }
    face.result = pairs.iter().map(|&[a, b, c, d, e, f]| ciede2000([a, b, c], [d, e, f])).collect();
    Ok(())
}

/// Text: an illuminant. Result: first and last wavelength, X, Y, Z of its white, then its power at every nm between (0
/// where it is lines only); message: its lines, `nm<tab>power` each.
pub fn illuminant(face: &mut Face) -> Result<(), String> {
    let [name] = face.lines()?;
    let light = Illuminant::named(or(&name, "D65")).map_err(words)?;
    face.result = vec![FIRST_NM, LAST_NM];
    face.result.extend(relative_white(&light));
    let count = (LAST_NM - FIRST_NM) as usize;
    face.result.extend((0..=count).map(|i| light.power(FIRST_NM + i as f64)));
    face.message = light.lines().iter().map(|(nm, power)| format!("{nm}\t{power}\n")).collect();
    Ok(())
}

/// Result: the CIE 1931 observer, three numbers a nm from 360 to 830.
pub fn observer(face: &mut Face) -> Result<(), String> {
    face.result = Observer::Cie1931.table().as_flattened().to_vec();
    Ok(())
}

/// Text: a medium as it stands in a stack. Numbers: wavelengths in nm. Result: n and k of each (a stated extension beyond
/// its data counts as data, as in colour sums).
pub fn index(face: &mut Face) -> Result<(), String> {
    let [name] = face.lines()?;
    let medium = StackText::parse(&format!("{name} / {name}")).map_err(words)?.media.swap_remove(0);
    let indices: Result<Vec<_>, OpticsError> = face
        .numbers
        .iter()
        .map(|&nm| match medium.index(nm, Beyond::Refuse) {
            Ok(index) => Ok(index),
            Err(_) => medium.index_extended(nm).map(|(index, _)| index),
        })
        .collect();
    face.result = indices.map_err(words)?.iter().flat_map(|n| [n.re, n.im]).collect();
    Ok(())
}
