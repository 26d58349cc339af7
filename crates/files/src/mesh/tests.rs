//! One tetrahedron in every format, and what a file may get wrong.

use iridesce_numerics::vector::cross;

use super::*;

const POINTS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn nowhere(name: &str) -> Result<Vec<u8>, String> {
    Err(format!("no {name}"))
}

fn decode(bytes: &[u8], format: MeshFormat) -> Result<Mesh, String> {
    decode_mesh(bytes, format, None, &nowhere)
}

fn obj() -> String {
    let mut text = String::from("mtllib a.mtl\n");
    POINTS.iter().for_each(|[x, y, z]| text += &format!("v {x} {y} {z}\n"));
    FACES.iter().for_each(|[a, b, c]| text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    text
}

fn ply(extra: &str, value: &str) -> String {
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n{extra}element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    );
    POINTS.iter().for_each(|[x, y, z]| text += &format!("{x} {y} {z}{value}\n"));
    FACES.iter().for_each(|[a, b, c]| text += &format!("3 {a} {b} {c}\n"));
    text
}

fn binary_ply(is_big: bool) -> Vec<u8> {
    let order = if is_big { "big" } else { "little" };
    let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float thickness_nm\nelement face 4\nproperty list uchar uint vertex_indices\nend_header\n").into_bytes();
    let mut put = |word: u32| bytes.extend(if is_big { word.to_be_bytes() } else { word.to_le_bytes() });
    POINTS.iter().for_each(|point| {
        point.iter().for_each(|&c| put((c as f32).to_bits()));
        put(320.5_f32.to_bits());
    });
    for corners in FACES {
        bytes.push(3);
        corners.iter().for_each(|&c| bytes.extend(if is_big { c.to_be_bytes() } else { c.to_le_bytes() }));
    }
    bytes
}

/// A glTF with its buffer inside; `node` goes into the node that holds the mesh.
fn gltf(node: &str, count: usize) -> String {
    use base64::Engine;
    let mut buffer = Vec::new();
    POINTS.iter().flatten().for_each(|&c| buffer.extend((c as f32).to_le_bytes()));
    FACES.iter().flatten().for_each(|&c| buffer.extend((c as u16).to_le_bytes()));
    let data = base64::engine::general_purpose::STANDARD.encode(&buffer);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0{node}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{data}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
                     {{"bufferView":1,"componentType":5123,"count":{count},"type":"SCALAR"}}]}}"#,
        buffer.len()
    )
}

#[test]
fn every_format_holds_the_same_tetrahedron() {
    let all = [
        decode(obj().as_bytes(), MeshFormat::Obj).unwrap(),
        decode(ply("", "").as_bytes(), MeshFormat::Ply).unwrap(),
        decode(&binary_ply(false), MeshFormat::Ply).unwrap(),
        decode(&binary_ply(true), MeshFormat::Ply).unwrap(),
        decode(gltf("", 12).as_bytes(), MeshFormat::Gltf).unwrap(),
    ];
    for mesh in &all {
        let corners = |mesh: &Mesh| -> Vec<[[f64; 3]; 3]> {
            mesh.triangles.iter().map(|t| t.map(|corner| mesh.positions[corner as usize])).collect()
        };
        assert_eq!(corners(mesh), FACES.map(|face| face.map(|corner| POINTS[corner as usize])));
        assert_eq!(mesh.open_edge(), None);
    }
    assert!(all[0].notes[0].contains("materials are left out") && all[1].notes.is_empty());
    assert_eq!(all[2].thickness_nm.as_deref(), Some(&[320.5; 4][..]));
    assert_eq!([all[0].is_in_metres, all[4].is_in_metres], [false, true]);
}

/// Whatever else vertices and faces carry, our own reader and the library's give the same mesh.
#[test]
fn bodies_are_read_as_the_library_reads_them() {
    for is_big in [false, true] {
        let order = if is_big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\r\nformat binary_{order}_endian 1.0\r\nelement extra 2\r\nproperty list uchar short a\r\nelement vertex 5\r\nproperty uchar red\r\n\
             property double y\r\nproperty float x\r\nproperty short z\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n\
             property float s\r\nproperty float t\r\nelement face 2\r\nproperty uchar flags\r\n\
             property list ushort short vertex_index\r\nproperty list uchar double more\r\nend_header\r\n"
        )
        .into_bytes();
        let mut number = |little: &[u8]| match is_big {
            true => bytes.extend(little.iter().rev()),
            false => bytes.extend(little),
        };
        for count in [1_u8, 2] {
            number(&[count]);
            (0..count).for_each(|_| number(&7_i16.to_le_bytes()));
        }
        for vertex in 0..5_u8 {
            let value = f32::from(vertex);
            number(&[vertex]);
            number(&f64::from(value * value).to_le_bytes());
            number(&value.to_le_bytes());
            number(&i16::from(vertex % 2).to_le_bytes());
            (0..5).for_each(|k| number(&(value + k as f32 + 0.5).to_le_bytes()));
        }
        for corners in [&[0_i16, 1, 2][..], &[4, 3, 1, 0]] {
            number(&[9]);
            number(&(corners.len() as u16).to_le_bytes());
            corners.iter().for_each(|corner| number(&corner.to_le_bytes()));
            number(&[1]);
            number(&0.25_f64.to_le_bytes());
        }
        let header = ply_file::header(&bytes).unwrap();
        let [own, library] = [ply_file::read(&bytes).unwrap(), ply_file::read_by_library(&bytes).unwrap()];
        assert_eq!(ply_body::read(&bytes, &header).unwrap().triangles, own.triangles);
        assert_eq!(own, library);
        assert_eq!(own.triangles, [[0, 1, 2], [4, 3, 1], [4, 1, 0]]);
        assert!(own.normals.is_some() && own.uv.is_some() && own.notes.len() == 2);
        assert!(ply_body::read(&bytes[..bytes.len() - 1], &header).is_none());
    }
}

#[test]
fn an_open_edge_is_named() {
    let mut mesh = decode(obj().as_bytes(), MeshFormat::Obj).unwrap();
    mesh.triangles.pop();
    let edge = mesh.open_edge().unwrap();
    assert_eq!((edge.triangle, edge.ends), (0, [POINTS[2], POINTS[1]]));
    // A face turned over is as bad as one that is missing.
    let mut turned = decode(obj().as_bytes(), MeshFormat::Obj).unwrap();
    turned.triangles[3].swap(0, 1);
    assert!(turned.open_edge().is_some());
}

#[test]
fn polygons_become_fans_and_corners_keep_their_own_normals() {
    let text =
        "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\nf 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let mesh = decode(text.as_bytes(), MeshFormat::Obj).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert_eq!(mesh.normals.unwrap(), vec![[0.0, 0.0, 1.0]; 4]);
    assert_eq!(mesh.uv.unwrap(), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
}

#[test]
fn nodes_move_turn_and_mirror() {
    let mesh = decode(gltf(r#","scale":[-2,1,1],"translation":[10,0,0]"#, 12).as_bytes(), MeshFormat::Gltf).unwrap();
    assert_eq!(mesh.positions[1], [8.0, 0.0, 0.0]);
    assert_eq!(mesh.open_edge(), None);
    // The outside stays outside: the volume by the divergence theorem is positive.
    let volume: f64 = mesh
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|corner| mesh.positions[corner as usize]);
            let n = cross(b, c);
            (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6.0
        })
        .sum();
    assert!((volume - 2.0 / 6.0).abs() < 1e-12, "{volume}");
}

#[test]
fn what_a_file_gets_wrong_is_named() {
    let cases: [(Vec<u8>, MeshFormat, &str); 15] = [
        (b"v 0 0 0\n".to_vec(), MeshFormat::Obj, "no faces"),
        (
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\n".to_vec(),
            MeshFormat::Obj,
            "line 5: a face asks for vertex 9, and there are 3",
        ),
        (
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//9\n".to_vec(),
            MeshFormat::Obj,
            "line 5: a face asks for normal 9",
        ),
        (b"v 0 0 0\nv 1 x 0\nv 0 1 0\nf 1 2 3\n".to_vec(), MeshFormat::Obj, "line 2: \"x\" is no number"),
        (b"v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n".to_vec(), MeshFormat::Obj, "vertex 1 lies at"),
        (b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n".to_vec(), MeshFormat::Obj, "none of its 1 triangles has an area"),
        (ply("", "").replace("3 0 2 1", "3 0 2 -1").into_bytes(), MeshFormat::Ply, "face 0 has a corner at vertex -1"),
        (
            ply("", "").replace("3 0 2 1", "3 0 2 7").into_bytes(),
            MeshFormat::Ply,
            "a corner at vertex 7, and there are 4",
        ),
        (
            ply("", "").replace("ascii 1.0", "ascii 1ii").into_bytes(),
            MeshFormat::Ply,
            "no PLY file that can be read: line 2 is \"format ascii 1ii\"; a format is ascii, binary_little_endian or",
        ),
        (ply("", "").replace("3 0 2 1", "2 0 2").into_bytes(), MeshFormat::Ply, "face 0 has 2 corners"),
        (
            ply("", "").replace("element face 4", "element face 1000000000").into_bytes(),
            MeshFormat::Ply,
            "declares 1000000000",
        ),
        (ply("property float thickness_nm\n", " -5").into_bytes(), MeshFormat::Ply, "thickness_nm of vertex 0"),
        (binary_ply(false)[..250].to_vec(), MeshFormat::Ply, "no PLY file"),
        (gltf("", 4000).into_bytes(), MeshFormat::Gltf, "needs 8000 bytes"),
        (b"{}".to_vec(), MeshFormat::Gltf, "no glTF file"),
    ];
    for (bytes, format, words) in cases {
        let error = decode(&bytes, format).unwrap_err();
        assert!(error.contains(words), "{words}: {error}");
        assert!(!error.contains(char::is_control), "{error:?}");
    }
    for children in ["[0]", "[1,1]", "[1,2]"] {
        let more = format!(r#","children":{children}}},{{"children":[2]}},{{"mesh":0"#);
        let error = decode(gltf(&more, 12).as_bytes(), MeshFormat::Gltf).unwrap_err();
        assert!(error.contains("hangs below more than one other"), "{children}: {error}");
    }
    let elsewhere = gltf("", 12).replace("data:application", "../secret.bin?");
    assert!(decode(elsewhere.as_bytes(), MeshFormat::Gltf).unwrap_err().contains("buffer 0"), "asked beside the file");
    assert!(MeshFormat::of(Path::new("x.stl")).unwrap_err().contains(".obj, .ply, .gltf or .glb"));
    assert_eq!(MeshFormat::of(Path::new("a/B.GLB")), Ok(MeshFormat::Gltf));
}

#[test]
fn what_the_library_would_panic_at_is_named() {
    let bytes = gltf("", 12);
    for (from, to, words) in [
        ("\"POSITION\":0", "\"POSITION\":7", "asks for accessor 7, and there are"),
        ("\"componentType\":5123", "\"componentType\":5122", "its indices are no whole numbers"),
    ] {
        let changed = bytes.replace(from, to);
        assert_ne!(changed, bytes, "{from}");
        let told = decode(changed.as_bytes(), MeshFormat::Gltf).unwrap_err();
        assert!(told.contains(words), "{told}");
    }
}

#[test]
fn the_line_of_a_bad_header_or_text_is_quoted_with_what_is_allowed() {
    let changed = |from: &str, to: &str| {
        let bytes = ply("", "").replacen(from, to, 1).into_bytes();
        decode(&bytes, MeshFormat::Ply).unwrap_err()
    };
    for (from, to, words) in [
        ("ply\n", "plx\n", "line 1 is \"plx\"; the first line of a PLY file is ply"),
        (
            "element vertex 4",
            "element vertex four",
            "line 3 is \"element vertex four\"; an element is a name and how many",
        ),
        ("element vertex 4", "element vertex -4", "line 3 is \"element vertex -4\"; an element is a name and how many"),
        ("property double x", "property real x", "line 4 is \"property real x\"; a property is a type and a name"),
        ("element face", "elem face", "line 7 is \"elem face 4\"; a header has the lines format, element"),
        ("end_header\n", "", "line 9 is \"0 0 0\"; a header has the lines"),
        ("vertex_indices", "corners", "its faces have no property vertex_indices"),
        ("\n1 0 0\n", "\n1 zero 0\n", "line 11, \"1 zero 0\", does not hold the numbers that the header says"),
    ] {
        let told = changed(from, to);
        assert!(told.contains(words), "{told}");
    }
    let headless = decode(b"ply\nformat ascii 1.0\n\xff\xfe\n", MeshFormat::Ply).unwrap_err();
    assert!(headless.contains("line 3 is \"\u{fffd}\u{fffd}\"; a header has the lines"), "{headless}");

    let faces =
        |corner: &str| decode(format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 {corner} 3\n").as_bytes(), MeshFormat::Obj);
    assert!(faces("two").unwrap_err().contains("line 4: \"two\" is no corner of a face: whole numbers are, as 3, 3/1"));
    let binary = decode(b"v 0 0 0\nv 1 0 0\nv \x00", MeshFormat::Obj).unwrap_err();
    assert!(binary.contains("line 3 holds a zero, byte 18 of the file; an OBJ file is text"), "{binary}");
    // Names in Latin-1 do no harm.
    let named = [b"o f\xfcnf\n".as_slice(), obj().as_bytes()].concat();
    assert_eq!(decode(&named, MeshFormat::Obj).unwrap().triangles.len(), 4);
}

/// Every mutation of small seeds is refused in words or read; none may panic, hang or take memory.
#[test]
fn torn_and_mutated_files_are_refused_in_words() {
    let seeds = [
        (obj().into_bytes(), MeshFormat::Obj),
        (binary_ply(false), MeshFormat::Ply),
        (gltf("", 12).into_bytes(), MeshFormat::Gltf),
    ];
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut draw = |n: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let (mut read, mut refused) = (0, 0);
    for (seed, format) in &seeds {
        for _ in 0..600 {
            let mut bytes = seed.clone();
            for _ in 0..=draw(3) {
                let at = draw(bytes.len());
                match draw(4) {
                    0 => bytes[at] = draw(256) as u8,
                    1 => bytes.truncate(at.max(1)),
                    2 => bytes.insert(at, b"0-9.e,\n\xff"[draw(8)]),
                    _ => drop(bytes.remove(at.min(bytes.len() - 1))),
                }
                if bytes.is_empty() {
                    bytes.push(0);
                }
            }
            match decode(&bytes, *format) {
                Ok(_) => read += 1,
                Err(why) => {
                    assert!(!why.is_empty());
                    refused += 1;
                }
            }
        }
    }
    assert!(read > 50 && refused > 500, "{read} {refused}");
}

/// The tetrahedron with its corners as whole numbers of 16 bits, every 8 bytes, each a share of 32767.
fn quantized(node: &str) -> String {
    use base64::Engine;
    let mut buffer = Vec::new();
    POINTS.iter().for_each(|point| {
        point.iter().for_each(|&c| buffer.extend(((c * 32767.0) as i16).to_le_bytes()));
        buffer.extend([0xAA; 2]);
    });
    FACES.iter().flatten().for_each(|&c| buffer.extend((c as u16).to_le_bytes()));
    let data = base64::engine::general_purpose::STANDARD.encode(&buffer);
    gltf(node, 12)
        .split_once("\"buffers\"")
        .map(|(head, _)| {
            format!(
                r#"{head}"extensionsUsed":["KHR_mesh_quantization"],"extensionsRequired":["KHR_mesh_quantization","KHR_materials_unlit"],
                "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{data}"}}],
                "bufferViews":[{{"buffer":0,"byteLength":32,"byteStride":8}},{{"buffer":0,"byteOffset":32,"byteLength":24}}],
                "accessors":[{{"bufferView":0,"componentType":5122,"normalized":true,"count":4,"type":"VEC3","min":[0,0,0],"max":[32767,32767,32767]}},
                             {{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}}]}}"#,
                buffer.len()
            )
        })
        .unwrap()
}

#[test]
fn whole_numbers_of_a_gltf_are_shares_or_lengths() {
    let mesh = decode(quantized("").as_bytes(), MeshFormat::Gltf).unwrap();
    assert_eq!(mesh.positions, POINTS);
    assert_eq!(mesh.open_edge(), None);
    let plain = quantized(r#","scale":[0.5,0.5,0.5]"#).replace("\"normalized\":true,", "");
    let mesh = decode(plain.as_bytes(), MeshFormat::Gltf).unwrap();
    assert_eq!(mesh.positions[1], [32767.0 * 0.5, 0.0, 0.0]);
    // What a reader must know and this one does not.
    for (name, words) in [("FOO_bar", "needs the extension \"FOO_bar\""), ("KHR_draco_mesh_compression", "compressed")]
    {
        let told = decode(quantized("").replace("KHR_materials_unlit", name).as_bytes(), MeshFormat::Gltf).unwrap_err();
        assert!(told.contains(words), "{told}");
    }
    let wrong = quantized("").replace("\"componentType\":5122", "\"componentType\":5125").replace("32767]", "1]");
    assert!(decode(wrong.as_bytes(), MeshFormat::Gltf).is_err());
}

#[test]
fn sparse_accessors_change_what_lies_below_or_nothing() {
    use base64::Engine;
    // Corner 3 is moved to (0, 0, 2) by a part that stands behind the dense one.
    let mut buffer = Vec::new();
    POINTS.iter().flatten().for_each(|&c| buffer.extend((c as f32).to_le_bytes()));
    FACES.iter().flatten().for_each(|&c| buffer.extend((c as u16).to_le_bytes()));
    buffer.extend([3_u8, 0, 0, 0]);
    [0.0_f32, 0.0, 2.0].iter().for_each(|c| buffer.extend(c.to_le_bytes()));
    let data = base64::engine::general_purpose::STANDARD.encode(&buffer);
    let text = |view: &str, count: usize, sparse: &str| {
        gltf("", 12).split_once("\"buffers\"").map(|(head, _)| {
            format!(
                r#"{head}"buffers":[{{"byteLength":88,"uri":"data:application/octet-stream;base64,{data}"}}],
                "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":24}},
                               {{"buffer":0,"byteOffset":72,"byteLength":1}},{{"buffer":0,"byteOffset":76,"byteLength":12}}],
                "accessors":[{{{view}"componentType":5126,"count":{count},"type":"VEC3","min":[0,0,0],"max":[1,1,2],
                               "sparse":{{"count":{sparse},"indices":{{"bufferView":2,"componentType":5121}},"values":{{"bufferView":3}}}}}},
                             {{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}}]}}"#
            )
        })
    };
    let read = |view: &str, count: usize, sparse: &str| {
        decode(text(view, count, sparse).unwrap().as_bytes(), MeshFormat::Gltf)
    };
    let mut moved = POINTS;
    moved[3] = [0.0, 0.0, 2.0];
    assert_eq!(read("\"bufferView\":0,", 4, "1").unwrap().positions, moved);
    assert!(read("", 4, "1").unwrap_err().contains("has an area"), "all corners but one are (0, 0, 0)");
    for (view, count, sparse, words) in [
        ("\"bufferView\":0,", 4, "5", "5 sparse values of 4"),
        ("\"bufferView\":0,", 3, "1", "changes element 3 of 3"),
        ("\"bufferView\":0,", 4, "2", "the sparse part of accessor 0 needs 2 bytes"),
        ("", 1_000_000_000, "1", "has 1000000000 elements, and the file 88 bytes"),
    ] {
        let told = read(view, count, sparse).unwrap_err();
        assert!(told.contains(words), "{words}: {told}");
    }
}

#[test]
fn buffers_are_asked_for_by_their_decoded_names() {
    let text = gltf("", 12).replace("data:application/octet-stream;base64,", "");
    let at = text.find("\"uri\":\"").unwrap() + 7;
    let end = at + text[at..].find('"').unwrap();
    let named = |name: &str| format!("{}{name}{}", &text[..at], &text[end..]);
    for (uri, wanted) in [
        ("my%20b%C3%BCffer.bin", "my b\u{fc}ffer.bin"),
        ("100%.bin", "100%.bin"),
        ("%ff.bin", "%ff.bin"),
        ("%2e%2e/x", "../x"),
    ] {
        let asked = std::cell::RefCell::new(Vec::new());
        let beside = |name: &str| {
            asked.borrow_mut().push(name.to_owned());
            Err(format!("no {name}"))
        };
        let told = decode_mesh(named(uri).as_bytes(), MeshFormat::Gltf, None, &beside).unwrap_err();
        assert_eq!(asked.borrow()[0], wanted);
        assert!(told.contains(&format!("no {wanted}")), "{told}");
    }
}

#[test]
fn a_part_of_a_gltf_is_read_alone_and_as_it_is_stored() {
    let text = gltf(r#","translation":[1.0,0.0,0.0]"#, 12);
    let read = |part: &str| decode_mesh(text.as_bytes(), MeshFormat::Gltf, Some(part), &nowhere);
    for part in ["/meshes/0", "/meshes/0/primitives/0"] {
        let mesh = read(part).unwrap();
        assert_eq!(mesh.positions, POINTS);
        assert!(mesh.is_in_metres);
    }
    assert_eq!(decode(text.as_bytes(), MeshFormat::Gltf).unwrap().positions[0], [1.0, 0.0, 0.0]);
    for part in ["/meshes/1", "/meshes/0/primitives/1", "meshes/0", "/nodes/0", "", "/meshes/-1", "/meshes/0/"] {
        let why = read(part).unwrap_err();
        assert!(why.contains("/meshes/M") && why.contains("M below 1"), "{why}");
    }
    let why = decode_mesh(obj().as_bytes(), MeshFormat::Obj, Some("/meshes/0"), &nowhere).unwrap_err();
    assert!(why.contains("only files of glTF"), "{why}");
}
