//! The scene language as one table: every key with what it takes, its unit, its range, its default and what it means.
//!
//! From this table come the reader's checks and alternatives, the keys that replace one another when a value is set
//! ([`crate::Scene::with_value`]), the table of keys in `docs/reference/scenes.md` and the JSON schema that editors read
//! (`iridesce check --schema`). A new key is a line here and a line in the reader of its part.

use iridesce_files::MAX_RADIANCE;

/// Largest coordinate, scene units, and one over the smallest length: squares and their products stay within the range
/// of the renderer's single precision (1e38).
pub const MAX_LENGTH: f64 = 1e9;
/// Thickest film: 1 cm. Its phase has 10^5 turns, of which single precision still tells hundredths apart.
pub const MAX_THICKNESS_NM: f64 = 1e7;
/// Largest side of a picture, pixels.
pub const MAX_SIDE: u64 = 1 << 20;
/// Most objects.
const MAX_OBJECTS: usize = 100_000;
/// Most instances that a scene file lists itself.
const MAX_INSTANCES: usize = 100_000;
/// Most bubbles of a cluster.
const MAX_BUBBLES: usize = 1000;
/// Most lights.
const MAX_LIGHTS: usize = 256;
/// Most layers of a coating.
const MAX_LAYERS: usize = 1000;

/// A kind of table.
pub struct Kind {
    /// What it is called in the docs and in the JSON schema.
    pub name: &'static str,
    /// What it is.
    pub words: &'static str,
    /// Its keys, in the order in which they are written.
    pub keys: &'static [Key],
    /// Keys of which it takes one, each with those that go with it.
    pub alternatives: &'static [&'static [&'static str]],
    /// Whether it may do without any of them.
    pub is_optional: bool,
    /// Keys that the language knows and this version does not.
    pub later: &'static [&'static str],
}

/// A key.
pub struct Key {
    /// Its name.
    pub name: &'static str,
    /// What it takes.
    pub takes: Takes,
    /// The unit, where its name does not say it.
    pub unit: &'static str,
    /// What it is where it is left out.
    pub default: Default,
    /// What it means.
    pub words: &'static str,
}

/// What stands for a key that is left out.
#[derive(Clone, Copy)]
pub enum Default {
    /// It may not be.
    Needed,
    /// One of several keys, of which one is needed: the kind says so.
    Alternative,
    /// Nothing, or what the words say.
    Words(&'static str),
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(u64),
    /// Three numbers.
    Triple([f64; 3]),
    /// A text.
    Text(&'static str),
    /// A table that holds no more than this key, with its own defaults.
    Table(&'static str),
    /// Width and height.
    Sides([u32; 2]),
}

/// What a key takes.
#[derive(Clone, Copy)]
pub enum Takes {
    /// A finite number.
    Number(Range),
    /// A whole number.
    Whole(u64, u64),
    /// Three coordinates.
    Point,
    /// Three coordinates with a direction.
    Vector,
    /// Width and height in pixels.
    Sides,
    /// The name of an object.
    Name,
    /// One of some texts; their complaint names them so.
    Choice(&'static [&'static str], &'static str),
    /// The name of a medium, a number or `[n, k]`.
    Medium,
    /// The name of an illuminant or a CSV file.
    Illuminant,
    /// An environment that is made by code.
    Builtin(&'static [&'static str]),
    /// A file.
    File,
    /// Any text.
    Text,
    /// A number or three of them, 0 to 1, or a table.
    Reflectance(&'static Kind),
    /// A number or two of them, 0 to 1, or a table.
    Roughness(&'static Kind),
    /// A number (a thickness) or a table.
    Thickness(&'static Kind),
    /// A table.
    Table(&'static Kind),
    /// A list of tables: at least and at most so many.
    List(&'static Kind, usize, usize),
    /// `true` or `false`.
    Bool,
    /// A factor, or three.
    Scale,
    /// Two numbers.
    Pair(Range),
    /// Three rows of four numbers.
    Matrix,
    /// A whole number, also below zero.
    Integer(i64, i64),
    /// A list of tables of the first kind, at most so many, or a table of the second.
    Instances(&'static Kind, &'static Kind, usize),
}

/// The numbers that a key allows.
#[derive(Clone, Copy)]
pub struct Range {
    /// In words, for a complaint.
    pub words: &'static str,
    /// The least.
    pub from: f64,
    /// The largest.
    pub to: f64,
    /// Beyond the range: nothing, zero too, or the range below zero too.
    pub also: Also,
}

/// What a range allows beside itself.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Also {
    /// Nothing.
    Nothing,
    /// Zero.
    Zero,
    /// The negative of all.
    Negative,
}

impl Range {
    const fn new(words: &'static str, from: f64, to: f64) -> Range {
        Range { words, from, to, also: Also::Nothing }
    }

    /// Whether a number is allowed; no NaN is.
    pub fn holds(&self, value: f64) -> bool {
        let within = |v: f64| (self.from..=self.to).contains(&v);
        value.is_finite()
            && match self.also {
                Also::Nothing => within(value),
                Also::Zero => value == 0.0 || within(value),
                Also::Negative => within(value.abs()),
            }
    }
}

/// The thickness of one layer.
pub const THICKNESS: Range = Range::new("a thickness in nm, from 0 to 1e7", 0.0, MAX_THICKNESS_NM);
const SHARE: Range = Range::new("a number from 0 to 1", 0.0, 1.0);
const LENGTH: Range = Range::new("a length > 0, from 1e-9 to 1e9", 1.0 / MAX_LENGTH, MAX_LENGTH);
const RADIANCE: Range = Range::new("a radiance >= 0, at most 1e12", 0.0, MAX_RADIANCE);
const IRRADIANCE: Range = Range::new("an irradiance >= 0, at most 1e12", 0.0, MAX_RADIANCE);
const INTENSITY: Range = Range::new("an intensity >= 0, at most 1e12", 0.0, MAX_RADIANCE);
const DIAMETER: Range = Range::new("an angle in degrees, from 1e-3 to 180", 1e-3, 180.0);
const CONE: Range = Range::new("an angle in degrees, from 1e-3 to 180", 1e-3, 180.0);
const SOFT: Range = Range::new("an angle in degrees, from 0 to 90", 0.0, 90.0);
const NUMERICAL_APERTURE: Range = Range::new("a sine, from 0 (parallel rays) to 0.999", 0.0, 0.999);
const ANGLE: Range = Range::new("a finite angle in degrees", f64::MIN, f64::MAX);
const FOV: Range = Range::new("an angle between 0 and 180 degrees (from 1e-6 to 179.9)", 1e-6, 179.9);
const APERTURE: Range =
    Range { also: Also::Zero, ..Range::new("a length, 0 (a pinhole) or from 1e-9 to 1e9", 1e-9, 1e9) };
const CURVATURE: Range = Range {
    also: Also::Negative,
    ..Range::new("a length other than 0, from 1e-9 to 1e9 either way (> 0 bulges towards the axis)", 1e-9, 1e9)
};
const UV_RANGE: Range = Range::new("from -1e6 to 1e6", -1e6, 1e6);
const SPAN: Range = Range::new("a length from -1e9 to 1e9", -MAX_LENGTH, MAX_LENGTH);
const EXPONENT: Range = Range::new("an exponent > 0", f64::MIN_POSITIVE, f64::MAX);
const RADIUS_MM: Range = Range::new("a radius in mm > 0, from 1e-9 to 1e12", 1e-9, 1e12);
const TIME: Range = Range::new("a time in s, from 0 to 600", 0.0, iridesce_flow::MOST_SECONDS);

const fn key(name: &'static str, takes: Takes, unit: &'static str, default: Default, words: &'static str) -> Key {
    Key { name, takes, unit, default, words }
}

const fn kind(name: &'static str, words: &'static str, keys: &'static [Key]) -> Kind {
    Kind { name, words, keys, alternatives: &[], is_optional: false, later: &[] }
}

const UNITS: &str = "scene units";

/// The whole scene.
pub static SCENE: Kind = kind(
    "scene",
    "a scene",
    &[
        key("version", Takes::Whole(0, u64::MAX), "", Default::Needed, "of the scene language: 1"),
        key(
            "unit",
            Takes::Choice(&["m", "cm", "mm"], "\"m\", \"cm\" or \"mm\""),
            "",
            Default::Text("cm"),
            "what 1.0 means: `\"m\"`, `\"cm\"` or `\"mm\"`",
        ),
        key("camera", Takes::Table(&CAMERA), "", Default::Needed, "who looks"),
        key("render", Takes::Table(&RENDER), "", Default::Words("its own defaults"), "how it is to be rendered"),
        key("object", Takes::List(&OBJECT, 1, MAX_OBJECTS), "", Default::Needed, "what is seen"),
        key("light", Takes::List(&LIGHT, 1, MAX_LIGHTS), "", Default::Needed, "what shines; radiances add"),
    ],
);

/// `[camera]`.
pub static CAMERA: Kind = Kind {
    alternatives: &[&["fov_deg"], &["orthographic_height", "numerical_aperture"]],
    is_optional: true,
    ..kind(
        "camera",
        "the camera",
        &[
            key("position", Takes::Point, UNITS, Default::Triple([0.0, 0.0, 16.0]), "where it stands"),
            key("target", Takes::Point, UNITS, Default::Triple([0.0; 3]), "what it looks at"),
            key("up", Takes::Point, "", Default::Triple([0.0, 1.0, 0.0]), "which way is up in the picture"),
            key("fov_deg", Takes::Number(FOV), "degrees", Default::Number(35.0), "full vertical angle"),
            key(
                "orthographic_height",
                Takes::Number(LENGTH),
                UNITS,
                Default::Words("a perspective view"),
                "full height of a parallel view",
            ),
            key(
                "aperture_radius",
                Takes::Number(APERTURE),
                UNITS,
                Default::Number(0.0),
                "radius of a thin lens; 0 is a pinhole",
            ),
            key(
                "focus_distance",
                Takes::Number(LENGTH),
                UNITS,
                Default::Words("the distance to `target`"),
                "of the plane that is sharp, along the view",
            ),
            key(
                "numerical_aperture",
                Takes::Number(NUMERICAL_APERTURE),
                "",
                Default::Words("parallel rays"),
                "of a microscope, with `orthographic_height`: sine of the steepest ray; sharp at `target`; not with `aperture_radius`",
            ),
            key(
                "polarizer_deg",
                Takes::Number(ANGLE),
                "degrees",
                Default::Words("none"),
                "a linear polariser before the camera: from `up`, clockwise in the picture; half of natural light passes",
            ),
            key("resolution", Takes::Sides, "pixels", Default::Sides([512, 512]), "width, height"),
        ],
    )
};

/// `[render]`.
pub static RENDER: Kind = kind(
    "render",
    "how the scene is to be rendered",
    &[
        key("samples", Takes::Whole(1, 1 << 20), "", Default::Whole(64), "camera rays per pixel"),
        key("seed", Takes::Whole(0, u64::MAX), "", Default::Whole(1), "another seed, other noise"),
        key(
            "max_depth",
            Takes::Whole(1, 1024),
            "",
            Default::Whole(16),
            "surface hits after which a path no longer branches",
        ),
        key(
            "backdrop",
            Takes::Bool,
            "",
            Default::Words("true"),
            "`false` leaves out what comes straight and unbent from an environment, through films or none; the plane `alpha` tells of it",
        ),
    ],
);

/// `[[object]]`.
pub static OBJECT: Kind = kind(
    "object",
    "an object",
    &[
        key("name", Takes::Name, "", Default::Words("`bubble`, `bubble-2`, ..."), "for messages and paths"),
        key("shape", Takes::Table(&SHAPE), "", Default::Table("sphere"), "where it is"),
        key("surface", Takes::Table(&SURFACE), "", Default::Table("film"), "what it is made of"),
        key("transform", Takes::Table(&TRANSFORM), "", Default::Words("none"), "moves, turns and scales the shape"),
        key(
            "instances",
            Takes::Instances(&TRANSFORM, &INSTANCES, MAX_INSTANCES),
            "",
            Default::Words("once"),
            "the object once for each transform, after its own; a list, or `{ file }`",
        ),
        key("uv", Takes::Table(&UV), "", Default::Words("as the shape has them"), "how maps lie on it"),
        key("bump", Takes::Table(&BUMP), "", Default::Words("none"), "heights that turn the shading normals"),
        key(
            "priority",
            Takes::Integer(-1000, 1000),
            "",
            Default::Words("0"),
            "of the medium behind it: inside several, the highest rules",
        ),
    ],
);

/// `shape = { ... }`.
pub static SHAPE: Kind = Kind {
    alternatives: &[
        &["sphere"],
        &["rectangle"],
        &["disk"],
        &["plane"],
        &["cap"],
        &["cylinder"],
        &["mesh"],
        &["bubbles"],
    ],
    ..kind(
        "shape",
        "one of",
        &[
            key("sphere", Takes::Table(&SPHERE), "", Default::Alternative, "front: outside"),
            key(
                "rectangle",
                Takes::Table(&RECTANGLE),
                "",
                Default::Alternative,
                "a parallelogram where the half edges are not at right angles; front: u x v",
            ),
            key("disk", Takes::Table(&DISK), "", Default::Alternative, "front: `normal`"),
            key("plane", Takes::Table(&PLANE), "", Default::Alternative, "unbounded; front: `normal`"),
            key(
                "cap",
                Takes::Table(&CAP),
                "",
                Default::Alternative,
                "part of a sphere, one face of a lens; front: `axis`",
            ),
            key("cylinder", Takes::Table(&CYLINDER), "", Default::Alternative, "front: outside"),
            key("mesh", Takes::Table(&MESH), "", Default::Alternative, "triangles of a file; front: by winding"),
            key("bubbles", Takes::Table(&BUBBLES), "", Default::Alternative, "a cluster of bubbles that share walls"),
        ],
    )
};

const CENTER: Key = key("center", Takes::Point, UNITS, Default::Triple([0.0; 3]), "the middle");
const RADIUS: Key = key("radius", Takes::Number(LENGTH), UNITS, Default::Number(4.0), "");

/// A sphere.
pub static SPHERE: Kind = kind("sphere", "a sphere", &[CENTER, RADIUS]);

/// A rectangle.
pub static RECTANGLE: Kind = kind(
    "rectangle",
    "a rectangle or parallelogram",
    &[
        CENTER,
        key("u", Takes::Vector, UNITS, Default::Triple([4.0, 0.0, 0.0]), "half edge"),
        key("v", Takes::Vector, UNITS, Default::Triple([0.0, 4.0, 0.0]), "half edge"),
    ],
);

/// A disk. Disks and caps face the default camera.
pub static DISK: Kind = kind(
    "disk",
    "a flat disk",
    &[CENTER, key("normal", Takes::Vector, "", Default::Triple([0.0, 0.0, 1.0]), ""), RADIUS],
);

/// A plane: ground.
pub static PLANE: Kind = kind(
    "plane",
    "an unbounded plane",
    &[
        key("point", Takes::Point, UNITS, Default::Triple([0.0; 3]), "one of its points"),
        key("normal", Takes::Vector, "", Default::Triple([0.0, 1.0, 0.0]), ""),
    ],
);

/// A cap.
pub static CAP: Kind = kind(
    "cap",
    "part of a sphere around a vertex",
    &[
        key("center", Takes::Point, UNITS, Default::Triple([0.0; 3]), "its vertex"),
        key("axis", Takes::Vector, "", Default::Triple([0.0, 0.0, 1.0]), "its normal there"),
        key(
            "radius_of_curvature",
            Takes::Number(CURVATURE),
            UNITS,
            Default::Number(8.0),
            "> 0 bulges towards the axis, < 0 is hollow",
        ),
        key("aperture_radius", Takes::Number(LENGTH), UNITS, Default::Number(4.0), "of its rim"),
    ],
);

/// A cylinder.
pub static CYLINDER: Kind = kind(
    "cylinder",
    "the side of a cylinder",
    &[
        CENTER,
        key("axis", Takes::Vector, "", Default::Triple([0.0, 1.0, 0.0]), "along it"),
        RADIUS,
        key("height", Takes::Number(LENGTH), UNITS, Default::Number(8.0), "from end to end"),
        key("open", Takes::Bool, "", Default::Words("true"), "`false` closes both ends"),
    ],
);

/// A mesh.
pub static MESH: Kind = kind(
    "mesh",
    "triangles of a file",
    &[
        key(
            "file",
            Takes::File,
            "",
            Default::Needed,
            "OBJ, PLY, glTF or GLB; coordinates in scene units, of glTF in m",
        ),
        key(
            "part",
            Takes::Text,
            "",
            Default::Words("the whole file"),
            "of glTF: `/meshes/M` or `/meshes/M/primitives/P`, that one alone, wherever its nodes put it",
        ),
    ],
);

/// A cluster of bubbles.
pub static BUBBLES: Kind = kind(
    "bubbles",
    "a cluster of bubbles that share walls; takes the surface film",
    &[key("spheres", Takes::List(&BALL, 1, MAX_BUBBLES), "", Default::Needed, "where they overlap they share a wall")],
);

/// A sphere of a cluster.
pub static BALL: Kind = kind("ball", "a sphere of a cluster", &[CENTER, RADIUS]);

/// `transform = { ... }`.
pub static TRANSFORM: Kind = kind(
    "transform",
    "`scale`, then `rotate_deg`, then `translate`; or `matrix` alone",
    &[
        key("scale", Takes::Scale, "", Default::Words("1"), "a factor, or three along x, y and z; about the origin"),
        key(
            "rotate_deg",
            Takes::Point,
            "degrees",
            Default::Triple([0.0; 3]),
            "about x, then y, then z of the world, through the origin",
        ),
        key("translate", Takes::Point, UNITS, Default::Triple([0.0; 3]), "what is added last"),
        key("matrix", Takes::Matrix, "", Default::Words("none"), "three rows of four: A and what is added"),
    ],
);

/// `instances = { file }`.
pub static INSTANCES: Kind =
    kind("instances", "transforms of a file", &[key("file", Takes::File, "", Default::Needed, "NPY, n x 3 x 4")]);

/// `uv = { ... }`.
pub static UV: Kind = kind(
    "uv",
    "u and v of every map on the object: scaled, then shifted; maps then repeat",
    &[
        key("scale", Takes::Pair(UV_RANGE), "", Default::Words("[1, 1]"), "of u and v"),
        key("offset", Takes::Pair(UV_RANGE), "", Default::Words("[0, 0]"), "added to u and v"),
    ],
);

/// `bump = { ... }`.
pub static BUMP: Kind = kind(
    "bump",
    "heights over u and v",
    &[
        key("map", Takes::File, "", Default::Needed, "grey, linear"),
        key("height", Takes::Number(SPAN), UNITS, Default::Needed, "of white, or of 1.0; black is 0"),
    ],
);

/// `surface = { ... }`.
pub static SURFACE: Kind = Kind {
    alternatives: &[&["film"], &["coating"], &["dielectric"], &["metal"], &["diffuse"], &["emitter"]],
    ..kind(
        "surface",
        "one of",
        &[
            key("film", Takes::Table(&FILM), "", Default::Alternative, "a free film"),
            key("coating", Takes::Table(&COATING), "", Default::Alternative, "layers on a substrate"),
            key(
                "dielectric",
                Takes::Table(&DIELECTRIC),
                "",
                Default::Alternative,
                "the bare surface of a transparent medium, which fills the space behind",
            ),
            key("metal", Takes::Table(&METAL), "", Default::Alternative, "the bare surface of an opaque medium"),
            key("diffuse", Takes::Table(&DIFFUSE), "", Default::Alternative, "a matt surface (Lambert's law)"),
            key("emitter", Takes::Table(&EMITTER), "", Default::Alternative, "glows on both sides, reflects nothing"),
        ],
    )
};

const ROUGHNESS_KEY: Key = key(
    "roughness",
    Takes::Roughness(&ROUGHNESS),
    "",
    Default::Number(0.0),
    "0 is a mirror; two numbers: along u and along v; facets are spread as GGX, alpha = roughness^2",
);

/// A free film.
pub static FILM: Kind = kind(
    "film",
    "a free film",
    &[
        key("medium", Takes::Medium, "", Default::Text("soap"), "what it is made of"),
        key(
            "thickness_nm",
            Takes::Thickness(&THICKNESS_MODEL),
            "nm",
            Default::Words("a gradient from 0 on top to 800 at the bottom"),
            "a number or a model",
        ),
        key("outside", Takes::Medium, "", Default::Text("air"), "on both its sides"),
        ROUGHNESS_KEY,
        key(
            "inner_thickness_nm",
            Takes::Thickness(&THICKNESS_MODEL),
            "nm",
            Default::Words("`thickness_nm`"),
            "of the walls between bubbles; shape `bubbles` only",
        ),
    ],
);

/// A coating.
pub static COATING: Kind = kind(
    "coating",
    "layers on a substrate",
    &[
        key(
            "layers",
            Takes::List(&LAYER, 0, MAX_LAYERS),
            "",
            Default::Words("none: the bare substrate"),
            "from outside inwards",
        ),
        key("substrate", Takes::Medium, "", Default::Needed, "fills the space behind"),
        ROUGHNESS_KEY,
    ],
);

/// A layer of a coating.
pub static LAYER: Kind = kind(
    "layer",
    "a layer of a coating",
    &[
        key("medium", Takes::Medium, "", Default::Needed, "what it is made of"),
        key("thickness_nm", Takes::Thickness(&THICKNESS_MODEL), "nm", Default::Needed, "a number or a model"),
    ],
);

/// A bare dielectric.
pub static DIELECTRIC: Kind = kind(
    "dielectric",
    "the bare surface of a transparent medium",
    &[key("medium", Takes::Medium, "", Default::Text("N-BK7"), ""), ROUGHNESS_KEY],
);

/// A bare metal.
pub static METAL: Kind = kind(
    "metal",
    "the bare surface of an opaque medium",
    &[key("medium", Takes::Medium, "", Default::Text("Al"), ""), ROUGHNESS_KEY],
);

/// A roughness that is no number.
pub static ROUGHNESS: Kind = kind(
    "roughness",
    "a grey map, laid over the shape by u and v",
    &[
        key("map", Takes::File, "", Default::Needed, "PNG, TIFF, OpenEXR or NPY; its numbers as they stand, 0 to 1"),
        key("min", Takes::Number(SHARE), "", Default::Number(0.0), "what 0 means"),
        key("max", Takes::Number(SHARE), "", Default::Number(1.0), "what 1, the largest whole number, means"),
    ],
);

/// A matt surface.
pub static DIFFUSE: Kind = kind(
    "diffuse",
    "a matt surface",
    &[key("reflectance", Takes::Reflectance(&REFLECTANCE), "", Default::Number(0.5), "a number or linear Rec.709")],
);

const POLARIZED: Key = key(
    "polarized_deg",
    Takes::Number(ANGLE),
    "degrees",
    Default::Words("natural light"),
    "makes it linearly polarised: from the world's y as the ray sees it (-z for vertical rays), anticlockwise for who looks the way the light goes",
);
const LAMP: Key = key("illuminant", Takes::Illuminant, "", Default::Text("D65"), "its spectrum");
/// A reflectance that is no number.
pub static REFLECTANCE: Kind = Kind {
    alternatives: &[&["map"], &["spectrum"]],
    ..kind(
        "reflectance",
        "one of",
        &[
            key(
                "map",
                Takes::File,
                "",
                Default::Alternative,
                "a picture laid over the shape by u and v: PNG and JPEG by their colour profile or as sRGB; OpenEXR, HDR and \
                 TIFF of 16 bits linear Rec.709",
            ),
            key(
                "spectrum",
                Takes::File,
                "",
                Default::Alternative,
                "a CSV file of nm and reflectance; beyond its ends the last value holds",
            ),
        ],
    )
};

/// An emitter.
pub static EMITTER: Kind = kind(
    "emitter",
    "a surface that glows",
    &[
        key("illuminant", Takes::Illuminant, "", Default::Text("D65"), "its spectrum"),
        key("radiance", Takes::Number(RADIANCE), "", Default::Number(1.0), "its Y"),
        POLARIZED,
    ],
);

/// A thickness that is no number.
pub static THICKNESS_MODEL: Kind = Kind {
    alternatives: &[
        &["gradient"],
        &["wedge"],
        &["lens_gap"],
        &["map", "min_nm", "max_nm", "channel", "page"],
        &["swirls"],
        &["flow"],
    ],
    ..kind(
        "thickness",
        "one of",
        &[
            key(
                "gradient",
                Takes::Table(&GRADIENT),
                "",
                Default::Alternative,
                "a power law in world height; not on planes and shapes that lie level",
            ),
            key("wedge", Takes::Table(&WEDGE), "", Default::Alternative, "linear between two points"),
            key(
                "lens_gap",
                Takes::Table(&LENS_GAP),
                "",
                Default::Alternative,
                "the gap under a lens, around the shape's centre",
            ),
            key("map", Takes::File, "", Default::Alternative, "a file laid over the shape by u and v"),
            key(
                "swirls",
                Takes::Table(&SWIRLS),
                "",
                Default::Alternative,
                "a made-up stirred film (smooth noise, no physics), laid over the shape by u and v; it fits to itself",
            ),
            key("flow", Takes::Table(&FLOW), "", Default::Alternative, "a film from its physics"),
            key(
                "min_nm",
                Takes::Number(THICKNESS),
                "nm",
                Default::Words("needed for whole numbers"),
                "of a map: what a whole number of 0 means",
            ),
            key(
                "max_nm",
                Takes::Number(THICKNESS),
                "nm",
                Default::Words("needed for whole numbers"),
                "of a map: what the largest whole number means",
            ),
            key(
                "channel",
                Takes::Text,
                "",
                Default::Words("the only one"),
                "of a map: `part:layer.channel` of an OpenEXR, `R`, `G`, `B` or `A` of a picture in colour",
            ),
            key(
                "page",
                Takes::Whole(1, 4096),
                "",
                Default::Words("the only one"),
                "of a map: the page of a TIFF, 1 is the first",
            ),
        ],
    )
};

/// By height.
pub static GRADIENT: Kind = kind(
    "gradient",
    "bottom + (top - bottom) s^exponent, s from 0 at the lowest point to 1 at the highest",
    &[
        key("top", Takes::Number(THICKNESS), "nm", Default::Needed, "at the highest point"),
        key("bottom", Takes::Number(THICKNESS), "nm", Default::Needed, "at the lowest point"),
        key("exponent", Takes::Number(EXPONENT), "", Default::Number(1.0), "1 is linear"),
    ],
);

/// Between two points.
pub static WEDGE: Kind = kind(
    "wedge",
    "linear between two points",
    &[
        key("from", Takes::Point, UNITS, Default::Needed, "where it begins"),
        key("to", Takes::Point, UNITS, Default::Needed, "where it ends"),
        key("start_nm", Takes::Number(THICKNESS), "nm", Default::Needed, "thickness at `from`"),
        key("end_nm", Takes::Number(THICKNESS), "nm", Default::Needed, "thickness at `to`"),
    ],
);

/// Under a lens.
pub static LENS_GAP: Kind = kind(
    "lens_gap",
    "contact_gap_nm + 1e6 (R - sqrt(R^2 - r^2)), R and r in mm",
    &[
        key("radius_mm", Takes::Number(RADIUS_MM), "mm", Default::Needed, "R, of the lens's face"),
        key("contact_gap_nm", Takes::Number(THICKNESS), "nm", Default::Number(0.0), "where it is narrowest"),
    ],
);

/// Smooth noise.
pub static SWIRLS: Kind = kind(
    "swirls",
    "a made-up stirred film",
    &[
        key("min_nm", Takes::Number(THICKNESS), "nm", Default::Needed, "the least"),
        key("max_nm", Takes::Number(THICKNESS), "nm", Default::Needed, "the largest"),
        key("seed", Takes::Whole(0, u64::MAX), "", Default::Whole(1), "another seed, other swirls"),
    ],
);

/// A film that has flowed.
pub static FLOW: Kind = kind(
    "flow",
    "a film from its physics, over a sphere or its caps by longitude and latitude, over the rest by u and v",
    &[
        key("preset", Takes::Choice(&iridesce_flow::PRESETS, ""), "", Default::Needed, "its name"),
        key("time_s", Takes::Number(TIME), "s", Default::Needed, "how long it has flowed"),
        key("seed", Takes::Whole(0, u64::MAX), "", Default::Whole(1), "another seed, another film"),
        key("columns", Takes::Whole(16, 16384), "cells", Default::Words("the preset's own"), "around or across; even"),
    ],
);

/// `[[light]]`.
pub static LIGHT: Kind = Kind {
    alternatives: &[&["environment"], &["sun"], &["directional"], &["point"], &["spot"]],
    ..kind(
        "light",
        "one of",
        &[
            key(
                "environment",
                Takes::Table(&ENVIRONMENT),
                "",
                Default::Alternative,
                "light from all around, infinitely far away",
            ),
            key("sun", Takes::Table(&SUN), "", Default::Alternative, "a disc, infinitely far away, which is seen"),
            key(
                "directional",
                Takes::Table(&DIRECTIONAL),
                "",
                Default::Alternative,
                "from one direction; without size, seen by nothing",
            ),
            key(
                "point",
                Takes::Table(&POINT),
                "",
                Default::Alternative,
                "from one point; without size, seen by nothing",
            ),
            key(
                "spot",
                Takes::Table(&SPOT),
                "",
                Default::Alternative,
                "from one point into a cone; without size, seen by nothing",
            ),
        ],
    )
};

const IRRADIANCE_KEY: Key = key(
    "irradiance",
    Takes::Number(IRRADIANCE),
    "",
    Default::Number(1.0),
    "its Y: a white diffuse surface that faces the light shows Y = irradiance / pi",
);
const INTENSITY_KEY: Key = key(
    "intensity",
    Takes::Number(INTENSITY),
    "",
    Default::Number(1.0),
    "irradiance at distance r, in scene units: intensity / r^2",
);

/// A sun.
pub static SUN: Kind = kind(
    "sun",
    "a disc of light, infinitely far away",
    &[
        key("direction", Takes::Vector, "", Default::Needed, "towards its middle"),
        key("angular_diameter_deg", Takes::Number(DIAMETER), "degrees", Default::Number(0.53), "full angle"),
        LAMP,
        IRRADIANCE_KEY,
        POLARIZED,
    ],
);

/// A light from one direction.
pub static DIRECTIONAL: Kind = kind(
    "directional",
    "light from one direction",
    &[key("direction", Takes::Vector, "", Default::Needed, "towards it"), LAMP, IRRADIANCE_KEY, POLARIZED],
);

/// A light from one point.
pub static POINT: Kind = kind(
    "point",
    "light from one point, the same to every side",
    &[key("position", Takes::Point, UNITS, Default::Needed, "where it is"), LAMP, INTENSITY_KEY, POLARIZED],
);

/// A light from one point into a cone.
pub static SPOT: Kind = kind(
    "spot",
    "light from one point into a cone",
    &[
        key("position", Takes::Point, UNITS, Default::Needed, "where it is"),
        key("target", Takes::Point, UNITS, Default::Triple([0.0; 3]), "what it points at"),
        key("cone_deg", Takes::Number(CONE), "degrees", Default::Number(30.0), "full angle of full intensity"),
        key(
            "soft_deg",
            Takes::Number(SOFT),
            "degrees",
            Default::Number(0.0),
            "of the fall to 0 (3 s^2 - 2 s^3) added on each side",
        ),
        LAMP,
        INTENSITY_KEY,
        POLARIZED,
    ],
);

/// Light from all around.
pub static ENVIRONMENT: Kind = Kind {
    alternatives: &[&["map", "layer"], &["illuminant"], &["builtin"]],
    ..kind(
        "environment",
        "one of `map`, `illuminant` and `builtin`, and",
        &[
            key("map", Takes::File, "", Default::Alternative, "latitude-longitude, OpenEXR or Radiance HDR"),
            key(
                "layer",
                Takes::Text,
                "",
                Default::Words("the only one"),
                "of a map: the layer of an OpenEXR, `part:layer`, where it holds several pictures",
            ),
            key("illuminant", Takes::Illuminant, "", Default::Alternative, "the same from everywhere"),
            key("builtin", Takes::Builtin(&["studio", "sky"]), "", Default::Alternative, "`\"studio\"` or `\"sky\"`"),
            key(
                "rotation_deg",
                Takes::Number(ANGLE),
                "degrees",
                Default::Number(0.0),
                "turns the map from +z towards +x",
            ),
            key(
                "radiance",
                Takes::Number(RADIANCE),
                "",
                Default::Number(1.0),
                "a factor for maps; the Y of an illuminant",
            ),
        ],
    )
};

/// Every kind, in the order of the docs.
pub static KINDS: [&Kind; 40] = [
    &SCENE,
    &CAMERA,
    &RENDER,
    &OBJECT,
    &SHAPE,
    &SPHERE,
    &RECTANGLE,
    &DISK,
    &PLANE,
    &CAP,
    &CYLINDER,
    &MESH,
    &BUBBLES,
    &BALL,
    &TRANSFORM,
    &INSTANCES,
    &UV,
    &BUMP,
    &SURFACE,
    &FILM,
    &COATING,
    &LAYER,
    &DIELECTRIC,
    &METAL,
    &ROUGHNESS,
    &DIFFUSE,
    &REFLECTANCE,
    &EMITTER,
    &THICKNESS_MODEL,
    &GRADIENT,
    &WEDGE,
    &LENS_GAP,
    &SWIRLS,
    &FLOW,
    &LIGHT,
    &ENVIRONMENT,
    &SUN,
    &DIRECTIONAL,
    &POINT,
    &SPOT,
];

impl Kind {
    /// One of its keys.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The names of its keys.
    pub fn names(&self) -> Vec<&'static str> {
        self.keys.iter().map(|key| key.name).collect()
    }

    /// The first key of each alternative that this version knows.
    pub fn choices(&self) -> Vec<&'static str> {
        self.alternatives.iter().map(|keys| keys[0]).filter(|name| !self.later.contains(name)).collect()
    }
}
