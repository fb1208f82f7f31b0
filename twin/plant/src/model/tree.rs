//! The order of the joints: one root, no loop, and every parent before its children.

use super::check::Source;
use super::{Joint, Link, ModelError};
use twin_input::work;

/// Joint indices in topological order and the root link's index. `joints` are in the order of the file.
pub(super) fn order(
    source: &Source<'_>,
    links: &[Link],
    joints: &[Joint],
) -> Result<(Vec<usize>, usize), ModelError> {
    let nodes = source.joints();
    let mut moved_by: Vec<Option<usize>> = vec![None; links.len()];
    for (index, joint) in joints.iter().enumerate() {
        if let Some(other) = moved_by[joint.child].replace(index) {
            let found = format!(
                "link {:?} is the child of both {:?} and {:?}",
                links[joint.child].name, joints[other].name, joint.name
            );
            let remedy = "a closed chain cannot be described: remove one joint";
            return Err(source.refuse(nodes[index], found, "one parent for each link", remedy));
        }
    }
    let roots: Vec<usize> = (0..links.len()).filter(|&link| moved_by[link].is_none()).collect();
    if let [first, second, ..] = roots[..] {
        let found = format!(
            "links {:?} and {:?} are both without parent",
            links[first].name, links[second].name
        );
        let remedy = "join one to the other with a joint, fixed if it does not move";
        return Err(source.refuse(source.links()[second], found, "one root link", remedy));
    }
    let mut moves: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (index, joint) in joints.iter().enumerate() {
        moves[joint.parent].push(index);
    }
    let mut reached: Vec<usize> = roots.clone();
    let mut order = Vec::with_capacity(joints.len());
    let mut ordered = vec![false; joints.len()];
    let mut next = 0;
    while let Some(&link) = reached.get(next) {
        next += 1;
        for &index in &moves[link] {
            work::steps(1);
            order.push(index);
            ordered[index] = true;
            reached.push(joints[index].child);
        }
    }
    match (roots.first(), ordered.iter().position(|ordered| !ordered)) {
        (Some(&root), None) => Ok((order, root)),
        (_, index) => {
            let node = index.map_or(source.root(), |index| nodes[index]);
            let found = "the joints form a loop";
            let remedy = "follow parent and child from here and break the circle";
            Err(source.refuse(node, found, "a tree with one root link", remedy))
        }
    }
}

/// For each link, the link nearest to the root among all links that fixed joints tie to it. `joints` are in topological order.
pub(super) fn rigid_groups(links: usize, joints: &[Joint]) -> Vec<usize> {
    let mut group: Vec<usize> = (0..links).collect();
    for joint in joints.iter().filter(|joint| joint.kind == super::JointKind::Fixed) {
        group[joint.child] = group[joint.parent];
    }
    group
}
