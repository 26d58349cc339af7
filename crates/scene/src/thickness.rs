//! Thicknesses: a number or a model.

use iridesce_flow::{FlowError, MOST_SECONDS};
use iridesce_thickness::{ThicknessError, ThicknessModel};

use crate::context::Context;
use crate::defaults;
use crate::error::SceneError;
use crate::reader::{Table, as_number};
use crate::tree::{Node, Value};

/// Thickest film: 1 cm. Its phase has 10^5 turns, of which single precision still tells hundredths apart.
pub const MAX_THICKNESS_NM: f64 = 1e7;
const THICKNESS: &str = "a thickness in nm, from 0 to 1e7";

fn is_thickness(v: f64) -> bool {
    (0.0..=MAX_THICKNESS_NM).contains(&v)
}

/// A thickness model, and its tree with every default.
pub fn thickness(
    given: Option<&Node>,
    path: &str,
    context: &mut Context<'_>,
) -> Result<(ThicknessModel, Node), SceneError> {
    let default = || {
        let ends = [("top", Node::number(defaults::TOP_NM)), ("bottom", Node::number(defaults::BOTTOM_NM))];
        Node::table([("gradient", Node::table(ends))])
    };
    let node = &given.cloned().unwrap_or_else(default);
    let wrong = |why: String| SceneError::new(format!("{path} {why}")).at(path, node.line);
    if let Some(thickness_nm) = as_number(node) {
        if !is_thickness(thickness_nm) {
            return Err(wrong(format!("must be {THICKNESS}, got {}", node.describe())));
        }
        let model = ThicknessModel::uniform(thickness_nm).map_err(|e| wrong(e.message))?;
        return Ok((model, Node::number(thickness_nm)));
    }
    if !matches!(node.value, Value::Table(_)) {
        return Err(wrong(format!("must be a number or a thickness model, got {}", node.describe())));
    }
    const KINDS: [&str; 6] = ["gradient", "wedge", "lens_gap", "map", "swirls", "flow"];
    // The range of a map stands beside it.
    let keys = ["gradient", "wedge", "lens_gap", "map", "swirls", "flow", "min_nm", "max_nm"];
    let table = Table::new(node, path, &keys, &[])?;
    let (kind, inner) = table.one_of(&KINDS)?;
    if kind == "map" {
        return map(&table, context);
    }
    if let Some(key) = ["min_nm", "max_nm"].into_iter().find(|key| table.get(key).is_some()) {
        let line = table.get(key).and_then(|n| n.line);
        return Err(SceneError::new(format!("{} goes with a map, not with a {kind}", table.path(key)))
            .at(table.path(key), line));
    }
    let path = table.path(kind);
    let (model, tree) = match kind {
        "gradient" => gradient(inner, path)?,
        "wedge" => wedge(inner, path)?,
        "swirls" => swirls(inner, path)?,
        "flow" => flow(inner, path)?,
        _ => lens_gap(inner, path)?,
    };
    Ok((model, Node::table([(kind, tree)])))
}

fn gradient(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, path, &["top", "bottom", "exponent"], &[])?;
    let top = table.needed_number("top", THICKNESS, is_thickness)?;
    let bottom = table.needed_number("bottom", THICKNESS, is_thickness)?;
    let exponent = table.number("exponent", defaults::EXPONENT, "an exponent > 0", |v| v > 0.0)?;
    let model = ThicknessModel::gradient(top, bottom, exponent).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([
        ("top", Node::number(top)),
        ("bottom", Node::number(bottom)),
        ("exponent", Node::number(exponent)),
    ]);
    Ok((model, tree))
}

fn wedge(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, path, &["from", "to", "start_nm", "end_nm"], &[])?;
    table.need("from")?;
    table.need("to")?;
    let from = table.triple("from", [0.0; 3])?;
    let to = table.triple("to", [0.0; 3])?;
    let start_nm = table.needed_number("start_nm", THICKNESS, is_thickness)?;
    let end_nm = table.needed_number("end_nm", THICKNESS, is_thickness)?;
    let model = ThicknessModel::wedge(from, to, start_nm, end_nm).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([
        ("from", Node::numbers(&from)),
        ("to", Node::numbers(&to)),
        ("start_nm", Node::number(start_nm)),
        ("end_nm", Node::number(end_nm)),
    ]);
    Ok((model, tree))
}

fn lens_gap(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, path, &["radius_mm", "contact_gap_nm"], &[])?;
    let is_radius = |v: f64| (1e-9..=1e12).contains(&v);
    let radius_mm = table.needed_number("radius_mm", "a radius in mm > 0, from 1e-9 to 1e12", is_radius)?;
    let contact_gap_nm = table.number("contact_gap_nm", defaults::CONTACT_GAP_NM, THICKNESS, is_thickness)?;
    let model = ThicknessModel::lens_gap(radius_mm, contact_gap_nm).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([("radius_mm", Node::number(radius_mm)), ("contact_gap_nm", Node::number(contact_gap_nm))]);
    Ok((model, tree))
}

fn swirls(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, path, &["min_nm", "max_nm", "seed"], &[])?;
    let min_nm = table.needed_number("min_nm", THICKNESS, is_thickness)?;
    let max_nm = table.needed_number("max_nm", THICKNESS, is_thickness)?;
    let seed = table.whole("seed", defaults::SWIRLS_SEED, 0, u64::MAX)?;
    let map = iridesce_thickness::swirls(min_nm, max_nm, seed).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([
        ("min_nm", Node::number(min_nm)),
        ("max_nm", Node::number(max_nm)),
        ("seed", Value::Int(seed.into()).into()),
    ]);
    Ok((ThicknessModel::Map(map), tree))
}

/// A film that has flowed for some seconds; the run is made here.
fn flow(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, path, &["preset", "time_s", "seed", "columns"], &[])?;
    let preset = table.needed_text("preset")?;
    let rule = format!("a time in s, from 0 to {MOST_SECONDS}");
    let time_s = table.needed_number("time_s", &rule, |v| (0.0..=MOST_SECONDS).contains(&v))?;
    let seed = table.whole("seed", defaults::FLOW_SEED, 0, u64::MAX)?;
    let columns = match table.get("columns") {
        None => None,
        Some(_) => Some(table.whole("columns", 0, 16, 16384)? as usize),
    };
    let field = crate::films::field(preset, time_s, seed, columns).map_err(|e| match e {
        FlowError::Parameter(e) => at_key(&table, node, e),
        other => SceneError::new(other.to_string()).at(table.path("preset"), node.line),
    })?;
    let tree = Node::table([
        ("preset", Node::text(preset)),
        ("time_s", Node::number(time_s)),
        ("seed", Value::Int(seed.into()).into()),
        ("columns", Value::Int(field.map().width() as i128).into()),
    ]);
    Ok((ThicknessModel::Flow(field), tree))
}

/// A map and its range.
fn map(table: &Table<'_>, context: &mut Context<'_>) -> Result<(ThicknessModel, Node), SceneError> {
    let name = table.needed_text("map")?;
    // The cheap checks first: a map can take seconds to read.
    let end = |key| match table.get(key) {
        None => Ok(None),
        Some(_) => table.needed_number(key, THICKNESS, is_thickness).map(Some),
    };
    let (min_nm, max_nm) = (end("min_nm")?, end("max_nm")?);
    let node = table.need("map")?;
    let grid = context.origin.resolve(name).and_then(|path| context.maps.thickness(&path, name));
    let grid = grid.map_err(|e| e.at(table.path("map"), node.line))?;
    let map = grid.in_range(min_nm, max_nm).map_err(|e| at_key(table, node, e))?;
    let mut entries = vec![("map", Node::text(name))];
    entries.extend(min_nm.map(|v| ("min_nm", Node::number(v))));
    entries.extend(max_nm.map(|v| ("max_nm", Node::number(v))));
    Ok((ThicknessModel::Map(map), Node::table(entries)))
}

/// What the model itself does not allow, at its key.
fn at_key(table: &Table<'_>, node: &Node, error: ThicknessError) -> SceneError {
    let path = table.path(error.key);
    let line = table.get(error.key).and_then(|n| n.line).or(node.line);
    SceneError::new(format!("{path} {}", error.message)).at(path, line)
}
