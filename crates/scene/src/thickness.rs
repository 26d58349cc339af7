//! Thicknesses: a number or a model.

use iridesce_flow::FilmRun;
use iridesce_thickness::{ThicknessError, ThicknessModel};

use crate::context::Reading;
use crate::error::SceneError;
use crate::field::ThicknessField;
use crate::files::map_file;
use crate::model::{Shape, Thickness};
use crate::reader::{Table, as_number};
use crate::schema::{self, MAX_THICKNESS_NM};
use crate::tree::{Node, Value};

/// Thickness of a film that states none: a linear gradient, nm.
const TOP_NM: f64 = 0.0;
const BOTTOM_NM: f64 = 800.0;

/// How thick a layer on this shape is, and its tree with every default. Laws are laid over the shape; no map is read and
/// nothing flows.
pub fn thickness(
    given: Option<&Node>,
    path: &str,
    shape: &Shape,
    context: &Reading<'_>,
) -> Result<(Thickness, Node), SceneError> {
    let default = || {
        let ends = [("top", Node::number(TOP_NM)), ("bottom", Node::number(BOTTOM_NM))];
        Node::table([("gradient", Node::table(ends))])
    };
    let node = &given.cloned().unwrap_or_else(default);
    let wrong = |why: String| SceneError::new(format!("{path} {why}")).at(path, node.line);
    let laid = |model: ThicknessModel| {
        if context.is_placed || matches!(shape, Shape::Mesh(_)) {
            return Ok(Thickness::Model(model));
        }
        let field = ThicknessField::new(model, shape, context.unit).map_err(wrong)?;
        if field.max_nm() > MAX_THICKNESS_NM {
            return Err(wrong(too_thick(field.max_nm())));
        }
        Ok(Thickness::Law(field))
    };
    if let Some(thickness_nm) = as_number(node) {
        let model = ThicknessModel::uniform(thickness_nm).map_err(|e| wrong(e.rule()))?;
        return Ok((laid(model)?, Node::number(thickness_nm)));
    }
    if matches!(&node.value, Value::Text(word) if word == "vertex") {
        return match shape {
            Shape::Mesh(_) => Ok((Thickness::Vertex, Node::text("vertex"))),
            _ => Err(wrong("can be \"vertex\" only on a mesh, whose file states thickness_nm at its vertices".into())),
        };
    }
    let table = Table::new(node, &schema::THICKNESS_MODEL, path)?;
    let (kind, inner) = table.choice()?;
    if kind == "map" {
        return map(&table, context);
    }
    let inside = table.path(kind);
    let (thickness, tree) = match kind {
        "swirls" => swirls(inner, inside)?,
        "flow" => flow(inner, inside)?,
        _ => {
            let law = match kind {
                "gradient" => gradient,
                "wedge" => wedge,
                _ => lens_gap,
            };
            let (model, tree) = law(inner, inside)?;
            (laid(model)?, tree)
        }
    };
    Ok((thickness, Node::table([(kind, tree)])))
}

/// What is wrong with a thickness that a scene may not have somewhere on a shape.
pub fn too_thick(max_nm: f64) -> String {
    format!("must be a thickness in nm, at most 1e7 all over the shape, got {max_nm:?}")
}

/// The largest thickness that can be told without reading a map or letting a film flow, nm.
pub fn most_nm(thickness: &Thickness) -> f64 {
    match thickness {
        Thickness::Law(field) => field.max_nm(),
        Thickness::Swirls { min_nm, max_nm, .. } => min_nm.max(*max_nm),
        Thickness::Model(model) if !matches!(model, ThicknessModel::LensGap(_)) => model.max_nm(),
        Thickness::Map { .. } | Thickness::Flow { .. } | Thickness::Model(_) | Thickness::Vertex => 0.0,
    }
}

fn gradient(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, &schema::GRADIENT, path)?;
    let top = table.number("top")?;
    let bottom = table.number("bottom")?;
    let exponent = table.number("exponent")?;
    let model = ThicknessModel::gradient(top, bottom, exponent).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([
        ("top", Node::number(top)),
        ("bottom", Node::number(bottom)),
        ("exponent", Node::number(exponent)),
    ]);
    Ok((model, tree))
}

fn wedge(node: &Node, path: String) -> Result<(ThicknessModel, Node), SceneError> {
    let table = Table::new(node, &schema::WEDGE, path)?;
    let from = table.triple("from")?;
    let to = table.triple("to")?;
    let start_nm = table.number("start_nm")?;
    let end_nm = table.number("end_nm")?;
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
    let table = Table::new(node, &schema::LENS_GAP, path)?;
    let radius_mm = table.number("radius_mm")?;
    let contact_gap_nm = table.number("contact_gap_nm")?;
    let model = ThicknessModel::lens_gap(radius_mm, contact_gap_nm).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([("radius_mm", Node::number(radius_mm)), ("contact_gap_nm", Node::number(contact_gap_nm))]);
    Ok((model, tree))
}

fn swirls(node: &Node, path: String) -> Result<(Thickness, Node), SceneError> {
    let table = Table::new(node, &schema::SWIRLS, path)?;
    let min_nm = table.number("min_nm")?;
    let max_nm = table.number("max_nm")?;
    let seed = table.whole("seed")?;
    let tree = Node::table([
        ("min_nm", Node::number(min_nm)),
        ("max_nm", Node::number(max_nm)),
        ("seed", Value::Int(seed.into()).into()),
    ]);
    Ok((Thickness::Swirls { min_nm, max_nm, seed }, tree))
}

/// A film that has flowed for some seconds.
fn flow(node: &Node, path: String) -> Result<(Thickness, Node), SceneError> {
    let table = Table::new(node, &schema::FLOW, path)?;
    let preset = table.text("preset")?;
    let time_s = table.number("time_s")?;
    let seed = table.whole("seed")?;
    let columns = match table.get("columns") {
        None => None,
        Some(_) => Some(table.whole("columns")? as usize),
    };
    let film = FilmRun::new(preset, seed, columns).map_err(|e| at_key(&table, node, e))?;
    let tree = Node::table([
        ("preset", Node::text(preset)),
        ("time_s", Node::number(time_s)),
        ("seed", Value::Int(seed.into()).into()),
        ("columns", Value::Int(film.parameters().columns as i128).into()),
    ]);
    Ok((Thickness::Flow { film, time_s }, tree))
}

/// A map and its range.
fn map(table: &Table<'_>, context: &Reading<'_>) -> Result<(Thickness, Node), SceneError> {
    let name = table.text("map")?;
    let (min_nm, max_nm) = (table.number_if_given("min_nm")?, table.number_if_given("max_nm")?);
    if let (Some(least), Some(most)) = (min_nm, max_nm)
        && most < least
    {
        return Err(table.wrong("max_nm", &format!("at least min_nm = {least:?}")));
    }
    let node = table.need("map")?;
    let mut file = map_file(context.origin, name).map_err(|e| e.at(table.path("map"), node.line))?;
    file.channel = table.get("channel").map(|_| table.text("channel")).transpose()?.map(str::to_owned);
    file.page = table.get("page").map(|_| table.whole("page")).transpose()?.map(|page| page as usize);
    let mut entries = vec![("map", Node::text(name))];
    entries.extend(min_nm.map(|v| ("min_nm", Node::number(v))));
    entries.extend(max_nm.map(|v| ("max_nm", Node::number(v))));
    entries.extend(file.channel.as_deref().map(|name| ("channel", Node::text(name))));
    entries.extend(file.page.map(|page| ("page", Value::Int(page as i128).into())));
    Ok((Thickness::Map { file, min_nm, max_nm }, Node::table(entries)))
}

/// What the model itself does not allow, at its key.
fn at_key(table: &Table<'_>, node: &Node, error: ThicknessError) -> SceneError {
    let path = table.path(&error.argument);
    let line = table.get(&error.argument).and_then(|n| n.line).or(node.line);
    SceneError::new(format!("{path} {}", error.rule())).at(path, line)
}
