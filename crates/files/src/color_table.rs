//! Colour tables as OpenEXR: a part for each table, its nodes as planes, what it covers as facts.

use std::path::Path;

use iridesce_optics::color::{ColorTable, ColorTableShape, Space};

use crate::error::{FileError, Stop};
use crate::exr::{Table, read_tables, tables_bytes, write_tables};
use crate::facts::{Fact, Facts};

/// What the planes of a file are called, in the order of a node's numbers (the fourth and the last are no more than padding).
const PLANES: [(&str, usize); 6] =
    [("XYZ.X", 0), ("XYZ.Y", 1), ("XYZ.Z", 2), ("slope.X", 4), ("slope.Y", 5), ("slope.Z", 6)];
const KIND: &str = "iridesce colour table 1";

/// A table read from a file, and the words that were saved with it.
pub type ReadTable = (ColorTable, Vec<(String, String)>);

/// The tables in the bytes of an EXR file, each with the words that were saved with it.
pub fn read_color_tables(bytes: &[u8]) -> Result<Vec<ReadTable>, FileError> {
    read_tables(bytes)?.into_iter().map(read_one).collect()
}

fn read_one(table: Table) -> Result<ReadTable, FileError> {
    let fact = |name: &str| table.facts.iter().find(|(known, _)| known == name).map(|(_, fact)| fact);
    if fact("kind") != Some(&Fact::Text(KIND.into())) {
        return Err(FileError::Argument(format!("it is no colour table: its attribute \"kind\" is not {KIND:?}")));
    }
    let number = |name: &str| match fact(name) {
        Some(Fact::Number(value)) => Ok(*value),
        _ => Err(FileError::Argument(format!("the colour table lacks the number {name:?}"))),
    };
    let shape = ColorTableShape {
        rows: table.height,
        columns: table.width,
        range_nm: [number("thickness_nm_from")?, number("thickness_nm_to")?],
        range_deg: [number("angle_deg_from")?, number("angle_deg_to")?],
        inverse_square: number("inverse_square")?,
        white: [number("white_x")?, 1.0, number("white_z")?],
        max_delta_e: number("max_delta_e")?,
        mean_delta_e: number("mean_delta_e")?,
        probes: number("probes")? as usize,
    };
    let mut nodes = vec![[0.0; 8]; table.width * table.height];
    for (name, place) in PLANES {
        let plane = table.planes.iter().find(|(known, _)| known == name);
        let (_, values) =
            plane.ok_or_else(|| FileError::Argument(format!("the colour table lacks the channel {name:?}")))?;
        nodes.iter_mut().zip(values).for_each(|(node, value)| node[place] = *value);
    }
    let inner = ColorTable::from_nodes(shape, nodes).map_err(|error| FileError::Argument(error.to_string()))?;
    let words = table.facts.into_iter().filter_map(|(name, fact)| match fact {
        Fact::Text(text) => Some((name, text)),
        _ => None,
    });
    Ok((inner, words.collect()))
}

/// Writes tables into one EXR file, a part each, with their names and facts.
pub fn write_color_tables(
    path: &Path,
    tables: &[(&ColorTable, &str, &Facts)],
    stop: Stop<'_>,
) -> Result<(), FileError> {
    let tables: Vec<Table> = tables.iter().map(|(table, name, facts)| part(table, name, facts)).collect();
    write_tables(path, &tables, stop)
}

/// The same file in memory.
pub fn color_tables_bytes(tables: &[(&ColorTable, &str, &Facts)]) -> Result<Vec<u8>, FileError> {
    let tables: Vec<Table> = tables.iter().map(|(table, name, facts)| part(table, name, facts)).collect();
    tables_bytes(&tables)
}

fn part(table: &ColorTable, name: &str, facts: &Facts) -> Table {
    let (shape, nodes) = (table.shape(), table.nodes());
    let mut planes: Vec<(String, Vec<f32>)> = PLANES
        .iter()
        .map(|(name, place)| ((*name).to_owned(), nodes.iter().map(|node| node[*place]).collect()))
        .collect();
    // Linear Rec.709, so that every viewer shows the colours.
    if let Some(rgb_from_xyz) = Space::LinearSrgb.rgb_from_xyz() {
        for (name, row) in ["R", "G", "B"].into_iter().zip(rgb_from_xyz) {
            let dot = |node: &[f32; 8]| (0..3).map(|i| row[i] * f64::from(node[i])).sum::<f64>() as f32;
            planes.push((name.to_owned(), nodes.iter().map(dot).collect()));
        }
    }
    let mut facts = facts.to_vec();
    facts.push(("kind".to_owned(), Fact::Text(KIND.into())));
    for (name, value) in [
        ("thickness_nm_from", shape.range_nm[0]),
        ("thickness_nm_to", shape.range_nm[1]),
        ("angle_deg_from", shape.range_deg[0]),
        ("angle_deg_to", shape.range_deg[1]),
        ("inverse_square", shape.inverse_square),
        ("white_x", shape.white[0]),
        ("white_z", shape.white[2]),
        ("max_delta_e", shape.max_delta_e),
        ("mean_delta_e", shape.mean_delta_e),
        ("probes", shape.probes as f64),
    ] {
        facts.push((name.to_owned(), Fact::Number(value)));
    }
    Table { name: name.to_owned(), width: shape.columns, height: shape.rows, planes, facts }
}
