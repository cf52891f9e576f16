//! Where the vertices of a glTF primitive stand: morph targets at their default weights, joints or the node's own place.

use glam::{DMat3, DMat4, DVec3};
use gltf::Semantic;

use super::accessors::Reader;
use crate::error::InputError;

/// The places of all nodes in the world.
pub(super) struct Places(Vec<DMat4>);

/// A node's own transform.
pub(super) fn local(node: &gltf::Node<'_>) -> DMat4 {
    let columns = node.transform().matrix().map(|column| column.map(f64::from));
    DMat4::from_cols_array_2d(&columns)
}

impl Places {
    /// From every node that is no other's child down; a node on a circle is at the origin.
    pub(super) fn new(document: &gltf::Document) -> Self {
        let mut children: Vec<Vec<usize>> = Vec::new();
        let mut locals = Vec::new();
        for node in document.nodes() {
            children.push(node.children().map(|n| n.index()).collect());
            locals.push(local(&node));
        }
        let mut child = vec![false; locals.len()];
        children.iter().flatten().for_each(|i| child[*i] = true);
        let mut open: Vec<(usize, DMat4)> =
            (0..locals.len()).filter(|i| !child[*i]).map(|i| (i, DMat4::IDENTITY)).collect();
        let mut places = vec![DMat4::IDENTITY; locals.len()];
        let mut seen = vec![false; locals.len()];
        while let Some((index, parent)) = open.pop() {
            if !std::mem::replace(&mut seen[index], true) {
                places[index] = parent * locals[index];
                open.extend(children[index].iter().map(|i| (*i, places[index])));
            }
        }
        Self(places)
    }

    /// The matrix of each joint of a skin: the joint's place after the inverse of that at binding.
    fn joints(&self, skin: &gltf::Skin<'_>, reader: &Reader<'_>) -> Result<Vec<DMat4>, InputError> {
        let place = format!("skins[{}].inverseBindMatrices", skin.index());
        let bound = match skin.inverse_bind_matrices() {
            None => None,
            Some(accessor) => Some(reader.floats::<16>(&accessor, &place)?),
        };
        let joints: Vec<usize> = skin.joints().map(|node| node.index()).collect();
        if let Some(bound) = bound.as_ref().filter(|b| b.len() < joints.len()) {
            let expected = format!("{} matrices, one a joint", joints.len());
            return Err(reader.error(place, &expected, bound.len().to_string()));
        }
        let inverse =
            |i: usize| bound.as_ref().map_or(DMat4::IDENTITY, |b| DMat4::from_cols_array(&b[i]));
        Ok(joints.iter().enumerate().map(|(i, node)| self.0[*node] * inverse(i)).collect())
    }
}

/// Vertices in the world.
pub(super) struct Posed {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) normals: Option<Vec<[f64; 3]>>,
    /// Whether the place of each vertex mirrors; one for all where no joints move them.
    mirrors: Vec<bool>,
}

impl Posed {
    /// Whether a triangle that begins at this vertex is turned inside out.
    pub(super) fn mirrors(&self, vertex: u32) -> bool {
        let own = self.mirrors.get(vertex as usize);
        own.or(self.mirrors.first()).copied().unwrap_or(false)
    }
}

/// Positions and normals of a primitive as they stand in the world.
pub(super) fn posed(
    reader: &Reader<'_>,
    node: &gltf::Node<'_>,
    own: DMat4,
    (primitive, place): (&gltf::Primitive<'_>, &str),
    places: &Places,
) -> Result<Posed, InputError> {
    let at = |name: &str| format!("{place}.attributes.{name}");
    let Some(accessor) = primitive.get(&Semantic::Positions) else {
        return Err(reader.error(at("POSITION"), "positions", "none".into()));
    };
    let mut positions = reader.floats::<3>(&accessor, &at("POSITION"))?;
    let mut normals = match primitive.get(&Semantic::Normals) {
        None => None,
        Some(accessor) => Some(reader.floats::<3>(&accessor, &at("NORMAL"))?),
    };
    let length = positions.len();
    let as_many = |found: usize, what: String| {
        let expected = format!("{length} entries, as POSITION has");
        if found == length { Ok(()) } else { Err(reader.error(what, &expected, found.to_string())) }
    };
    if let Some(normals) = &normals {
        as_many(normals.len(), at("NORMAL"))?;
    }
    let weights = node.weights().or_else(|| node.mesh().and_then(|mesh| mesh.weights()));
    let weights = weights.unwrap_or_default().iter().copied().map(f64::from);
    for (index, (target, weight)) in primitive.morph_targets().zip(weights).enumerate() {
        if weight == 0.0 {
            continue;
        }
        let place = |name: &str| format!("{place}.targets[{index}].{name}");
        let add = |accessor: Option<gltf::Accessor<'_>>, name, to: &mut Vec<[f64; 3]>| {
            let Some(accessor) = accessor else { return Ok::<(), InputError>(()) };
            let moves = reader.floats::<3>(&accessor, &place(name))?;
            as_many(moves.len(), place(name))?;
            for (to, by) in to.iter_mut().zip(moves) {
                *to = (DVec3::from(*to) + weight * DVec3::from(by)).to_array();
            }
            Ok(())
        };
        add(target.positions(), "POSITION", &mut positions)?;
        if let Some(normals) = &mut normals {
            add(target.normals(), "NORMAL", normals)?;
        }
    }
    let matrices = match node.skin() {
        None => vec![own],
        Some(skin) => {
            let joints = places.joints(&skin, reader)?;
            blended(reader, primitive, &joints, (length, own), &at)?
        }
    };
    let mut mirrors = Vec::with_capacity(matrices.len());
    let one = matrices.len() == 1;
    let mut turns = Vec::with_capacity(matrices.len());
    for matrix in &matrices {
        let (turn, mirrored) = for_normals(*matrix);
        turns.push(turn);
        mirrors.push(mirrored);
    }
    let which = |i: usize| if one { 0 } else { i };
    for (i, position) in positions.iter_mut().enumerate() {
        *position = matrices[which(i)].transform_point3(DVec3::from(*position)).to_array();
    }
    for (i, normal) in normals.iter_mut().flatten().enumerate() {
        *normal = (turns[which(i)] * DVec3::from(*normal)).to_array();
    }
    Ok(Posed { positions, normals, mirrors })
}

/// The matrix of each vertex: its joints', by their weights.
fn blended(
    reader: &Reader<'_>,
    primitive: &gltf::Primitive<'_>,
    joints: &[DMat4],
    (length, own): (usize, DMat4),
    at: &impl Fn(&str) -> String,
) -> Result<Vec<DMat4>, InputError> {
    let mut sums = vec![(DMat4::ZERO, 0.0); length];
    for set in 0.. {
        let (Some(which), Some(weights)) =
            (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set)))
        else {
            break;
        };
        let place = at(&format!("JOINTS_{set}"));
        let which = reader.unsigned::<4>(&which, &place)?;
        let weights = reader.floats::<4>(&weights, &at(&format!("WEIGHTS_{set}")))?;
        if which.len() != length || weights.len() != length {
            let found = format!("{} and {}", which.len(), weights.len());
            let expected = format!("{length} joints and weights, as POSITION has");
            return Err(reader.error(place, &expected, found));
        }
        for ((sum, which), weights) in sums.iter_mut().zip(which).zip(weights) {
            for (joint, weight) in which.into_iter().zip(weights) {
                if weight != 0.0 {
                    let Some(matrix) = joints.get(joint as usize) else {
                        let expected = format!("joints below {}", joints.len());
                        return Err(reader.error(place, &expected, joint.to_string()));
                    };
                    sum.0 += *matrix * weight;
                    sum.1 += weight;
                }
            }
        }
    }
    // Weights should sum to 1; without any the vertex stays where its node puts it.
    let matrix =
        |(sum, weight): (DMat4, f64)| if weight > 0.0 { sum * (1.0 / weight) } else { own };
    Ok(sums.into_iter().map(matrix).collect())
}

/// The cofactors of a place, turned around where it mirrors: a positive multiple of the inverse transpose, which exists
/// even where a scale is zero. Second: whether it mirrors.
fn for_normals(place: DMat4) -> (DMat3, bool) {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(place);
    let mirrors = x.cross(y).dot(z) < 0.0;
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    (if mirrors { -cofactors } else { cofactors }, mirrors)
}
