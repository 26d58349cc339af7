//! Where an object is put: transforms, instances, how maps lie on it, bumps.

use std::sync::Arc;

use crate::affine::Affine;
use crate::context::Reading;
use crate::error::SceneError;
use crate::files::map_file;
use crate::model::{Bump, Instances, Placement, UvMap};
use crate::reader::{Table, as_matrix, as_numbers, as_scales};
use crate::schema;
use crate::tree::{Node, Value};

/// `transform` and `instances` of an object, and their trees, where they are given.
pub fn placement(
    table: &Table<'_>,
    context: &Reading<'_>,
    entries: &mut Vec<(&'static str, Node)>,
) -> Result<Placement, SceneError> {
    let mut placement = Placement::default();
    if let Some(node) = table.get("transform") {
        let (affine, tree) = transform(node, table.path("transform"))?;
        placement.transform = affine;
        entries.push(("transform", tree));
    }
    if let Some(node) = table.get("instances") {
        let path = table.path("instances");
        let (instances, tree) = match &node.value {
            Value::List(items) => {
                let read = |(i, item): (usize, &Node)| transform(item, format!("{path}.{i}"));
                let (all, trees): (Vec<Affine>, Vec<Node>) =
                    items.iter().enumerate().map(read).collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
                (Instances::List(Arc::from(all)), Value::List(trees).into())
            }
            _ => {
                let inner = Table::new(node, &schema::INSTANCES, path)?;
                let name = inner.text("file")?;
                let file = map_file(context.origin, name).map_err(|e| e.at(inner.path("file"), inner.line("file")))?;
                (Instances::File(file), Node::table([("file", Node::text(name))]))
            }
        };
        placement.instances = instances;
        entries.push(("instances", tree));
    }
    Ok(placement)
}

fn transform(node: &Node, path: String) -> Result<(Affine, Node), SceneError> {
    let table = Table::new(node, &schema::TRANSFORM, path)?;
    let (affine, tree) = match table.get("matrix") {
        Some(given) => {
            if let Some(other) = ["scale", "rotate_deg", "translate"].into_iter().find(|key| table.get(key).is_some()) {
                return Err(table.wrong(other, "left out beside matrix, which says all"));
            }
            let rows = as_matrix(given).unwrap_or(Affine::IDENTITY.rows);
            (Affine { rows }, Node::table([("matrix", given.without_lines())]))
        }
        None => {
            let scale = table.get("scale").and_then(as_scales).unwrap_or([1.0; 3]);
            let (rotate_deg, translate) = (table.triple("rotate_deg")?, table.triple("translate")?);
            let scale_tree = table.get("scale").map_or_else(|| Node::number(1.0), Node::without_lines);
            let tree = Node::table([
                ("scale", scale_tree),
                ("rotate_deg", Node::numbers(&rotate_deg)),
                ("translate", Node::numbers(&translate)),
            ]);
            (Affine::placed(scale, rotate_deg, translate), tree)
        }
    };
    if affine.inverse().is_none() {
        return Err(table.wrong("matrix", "a map that has an inverse: no direction may be pressed flat"));
    }
    Ok((affine, tree))
}

/// How maps lie on an object.
pub fn uv(table: &Table<'_>, entries: &mut Vec<(&'static str, Node)>) -> Result<UvMap, SceneError> {
    let Some(node) = table.get("uv") else { return Ok(UvMap::default()) };
    let inner = Table::new(node, &schema::UV, table.path("uv"))?;
    let pair = |key: &str| inner.get(key).and_then(as_numbers).and_then(|pair| <[f64; 2]>::try_from(pair).ok());
    let uv = UvMap { scale: pair("scale").unwrap_or([1.0; 2]), offset: pair("offset").unwrap_or([0.0; 2]) };
    entries.push(("uv", Node::table([("scale", Node::numbers(&uv.scale)), ("offset", Node::numbers(&uv.offset))])));
    Ok(uv)
}

/// The bump map of an object.
pub fn bump(
    table: &Table<'_>,
    context: &Reading<'_>,
    entries: &mut Vec<(&'static str, Node)>,
) -> Result<Option<Bump>, SceneError> {
    let Some(node) = table.get("bump") else { return Ok(None) };
    let inner = Table::new(node, &schema::BUMP, table.path("bump"))?;
    let (name, height) = (inner.text("map")?, inner.number("height")?);
    let file = map_file(context.origin, name).map_err(|e| e.at(inner.path("map"), inner.line("map")))?;
    entries.push(("bump", Node::table([("map", Node::text(name)), ("height", Node::number(height))])));
    Ok(Some(Bump { file, height }))
}
