//! What each picture of an exchange shows.

use super::drawing::{Colour, Drawing, Pen, Point, Window};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex};
use crate::output::picture::{AMBER, Map, SIGNED, SPEED, STEP, sections};
use crate::remesh::Steps;
use crate::scene::{RemeshMethod, Scene};
use crate::simulation::{Rehearsal, Successor};

/// A picture of one step, the whole gel and a close-up.
pub(super) struct Panel {
    /// Beginning of the names of its files.
    pub name: &'static str,
    pub title: &'static str,
    /// What is seen, in a sentence.
    pub about: &'static str,
    pub scale: Option<Scale>,
    pub whole: Vec<u8>,
    pub close: Vec<u8>,
}

/// What the colours mean.
#[derive(Clone, Copy)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    pub unit: &'static str,
    pub map: &'static Map,
}

impl Scale {
    fn colour(&self, value: f64) -> Colour {
        self.map.at((value - self.low) / (self.high - self.low).max(f64::MIN_POSITIVE))
    }
}

const INK: Colour = [24, 28, 36];
const STEEL: Colour = [150, 156, 168];
const ROSE: Colour = [224, 122, 118];
const PAPER: Colour = [255; 3];

/// A triangulation to be drawn.
struct Triangles {
    points: Vec<Point>,
    corners: Vec<[usize; 3]>,
}

/// All of an exchange that its pictures share.
struct Stage<'a> {
    shown: &'a Rehearsal,
    old: Triangles,
    /// The boundary of the old mesh.
    outline: Vec<[Point; 2]>,
    bodies: Vec<Vec<Point>>,
    windows: [Window; 2],
}

/// The pictures in order.
pub(super) fn panels(shown: &Rehearsal, scene: &Scene) -> Vec<Panel> {
    let stage = Stage::new(shown, scene);
    let mut panels = vec![stage.worn(), stage.bends(), stage.sizes()];
    if let Ok(steps) = &shown.steps {
        panels.extend([stage.quadtree(steps), stage.background(steps), stage.distance(steps)]);
        panels.extend([stage.immersed(steps), stage.trimmed(steps)]);
    }
    panels.push(stage.velocity_before());
    panels
        .extend(shown.successors.iter().filter_map(|(method, new)| Some(stage.velocity(*method, new.as_ref().ok()?))));
    panels
}

impl Triangles {
    fn of(points: &[Vector<2>], corners: Vec<[usize; 3]>) -> Self {
        Self { points: points.iter().map(|p| [p[0], p[1]]).collect(), corners }
    }

    fn of_mesh(points: &[Vector<2>], elements: &[Simplex]) -> Self {
        Self::of(points, elements.iter().map(|e| [e[0], e[1], e[2]].map(NodeId::index)).collect())
    }

    fn at(&self, triangle: usize) -> [Point; 3] {
        self.corners[triangle].map(|p| self.points[p])
    }

    /// Each edge once.
    fn edges(&self) -> Vec<[Point; 2]> {
        let sides = self.corners.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut pairs: Vec<[usize; 2]> = sides.map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.into_iter().map(|pair| pair.map(|p| self.points[p])).collect()
    }
}

impl<'a> Stage<'a> {
    fn new(shown: &'a Rehearsal, scene: &Scene) -> Self {
        let frame = &shown.frame;
        let points: Vec<Point> = frame.points.iter().map(|p| [p.x, p.z]).collect();
        let corners = frame.cells.nodes.iter().map(|nodes| [0, 1, 2].map(|k| nodes[k] as usize)).collect();
        let outline = frame.cells.facets.iter().map(|f| [f[0], f[1]].map(|node| points[node as usize])).collect();
        let old = Triangles { points, corners };
        let worst = (0..shown.shapes.len()).min_by(|a, b| shown.shapes[*a].total_cmp(&shown.shapes[*b])).unwrap_or(0);
        let windows = windows(&old, worst);
        Self { shown, old, outline, bodies: sections(frame, scene), windows }
    }

    /// A panel whose pictures are drawn by `draw`; bodies lie behind.
    fn panel(
        &self,
        (name, title): (&'static str, &'static str),
        scale: Option<Scale>,
        about: &'static str,
        draw: impl Fn(&mut Drawing),
    ) -> Panel {
        let [whole, close] = self.windows.map(|window| {
            let mut drawing = Drawing::new(window);
            for body in &self.bodies {
                (2..body.len()).for_each(|i| drawing.fill([body[0], body[i - 1], body[i]], |_| STEEL));
            }
            draw(&mut drawing);
            drawing.png()
        });
        Panel { name, title, about, scale, whole, close }
    }

    fn worn(&self) -> Panel {
        let scale = Scale { low: 0.0, high: 1.0, unit: "", map: &STEP };
        self.panel(
            ("worn", "The worn mesh"),
            Some(scale),
            "The mesh that ends, coloured by the quality of its elements: 1 is equilateral, 0 flat.",
            |drawing| {
                flat(drawing, &self.old, |e| scale.colour(self.shown.shapes[e]));
                edges(drawing, &self.old);
            },
        )
    }

    fn bends(&self) -> Panel {
        let scale = Scale { low: 0.0, high: 90.0, unit: "°", map: &SPEED };
        self.panel(
            ("indicator", "How far the fields bend"),
            Some(scale),
            "The indicator: the greatest angle between \
            the graphs of displacement or velocity over an element and over its neighbours.",
            |drawing| {
                flat(drawing, &self.old, |e| scale.colour(self.shown.bend[e].to_degrees()));
            },
        )
    }

    fn sizes(&self) -> Panel {
        let size = &self.shown.size;
        let low = size.iter().copied().fold(f64::MAX, f64::min);
        let high = size.iter().copied().fold(0.0, f64::max);
        let scale = Scale { low, high, unit: "m", map: &STEP };
        self.panel(
            ("sizes", "How fine the new mesh should be"),
            Some(scale),
            "Target sizes from the indicator, the distance from the body and the growth that is allowed.",
            |drawing| {
                smooth(drawing, &self.old, size, &scale);
            },
        )
    }

    fn quadtree(&self, steps: &Steps) -> Panel {
        self.panel(
            ("quadtree", "The quadtree"),
            None,
            "A balanced quadtree over the square around the gel: cells that \
            meet the gel are no larger than the target sizes in them.",
            |drawing| {
                flat(drawing, &self.old, |_| AMBER);
                let pen = thin(drawing, steps.cells.iter().map(|cell| cell.edge).fold(f64::MAX, f64::min));
                for cell in &steps.cells {
                    let [x, z, half] = [cell.middle[0], cell.middle[1], 0.5 * cell.edge];
                    let corners = [[x - half, z - half], [x + half, z - half], [x + half, z + half]];
                    drawing.line([corners[0], corners[1]], &pen);
                    drawing.line([corners[1], corners[2]], &pen);
                }
            },
        )
    }

    fn background(&self, steps: &Steps) -> Panel {
        let triangles = Triangles::of(&steps.background.points, steps.background.triangles.clone());
        self.panel(
            ("delaunay", "The Delaunay triangulation of its points"),
            None,
            "The middles of the cells, triangulated: the gel plays no part in it.",
            |drawing| {
                flat(drawing, &self.old, |_| AMBER);
                edges(drawing, &triangles);
            },
        )
    }

    fn distance(&self, steps: &Steps) -> Panel {
        let triangles = Triangles::of(&steps.background.points, steps.background.triangles.clone());
        let reach = 2.0 * self.windows[1].half;
        let scale = Scale { low: -reach, high: reach, unit: "m", map: &SIGNED };
        self.panel(
            ("distance", "The signed distance"),
            Some(scale),
            "The distance of the points from the boundary of \
            the gel, negative inside, and its linear interpolant: the gel is where that is below zero.",
            |drawing| {
                smooth(drawing, &triangles, &steps.distance, &scale);
                edges(drawing, &triangles);
                self.outline(drawing);
            },
        )
    }

    fn immersed(&self, steps: &Steps) -> Panel {
        let immersed = &steps.immersed;
        let triangles = Triangles::of(&immersed.points, immersed.triangles.clone());
        let has = |e: usize, is: &dyn Fn(f64) -> bool| triangles.corners[e].iter().any(|p| is(immersed.distance[*p]));
        self.panel(
            ("immersed", "The gel immersed in the triangulation"),
            None,
            "Points nearer than 0.3 of a cell have \
            been moved onto the boundary (dots); amber triangles are inside, red ones are cut.",
            |drawing| {
                flat(drawing, &triangles, |e| match (has(e, &|d| d > 0.0), has(e, &|d| d < 0.0)) {
                    (true, true) => ROSE,
                    (true, false) => PAPER,
                    (false, _) => AMBER,
                });
                edges(drawing, &triangles);
                self.outline(drawing);
                let pen = Pen {
                    width: (0.0035 * drawing.pixels(2.0 * self.windows[0].half)).min(5.0),
                    strength: 1.0,
                    colour: INK,
                };
                let snapped = immersed.points.iter().zip(&immersed.distance).filter(|(_, distance)| **distance == 0.0);
                snapped.for_each(|(p, _)| drawing.dot([p[0], p[1]], &pen));
            },
        )
    }

    fn trimmed(&self, steps: &Steps) -> Panel {
        let triangles = Triangles::of_mesh(&steps.proposal.position, &steps.proposal.elements);
        self.panel(
            ("trimmed", "The mesh that is cut out"),
            None,
            "What is outside is gone, triangles that the \
            boundary cuts are cut, and quadrilaterals are divided by their better diagonal.",
            |drawing| {
                flat(drawing, &triangles, |_| AMBER);
                edges(drawing, &triangles);
            },
        )
    }

    fn velocity_before(&self) -> Panel {
        let values: Vec<f64> = self.shown.frame.velocities.iter().map(|v| v.z).collect();
        let scale = self.speeds();
        self.panel(
            ("velocity-before", "The vertical velocity on the old mesh"),
            Some(scale),
            "What is to be carried over.",
            |drawing| {
                smooth(drawing, &self.old, &values, &scale);
                edges(drawing, &self.old);
            },
        )
    }

    fn velocity(&self, method: RemeshMethod, new: &Successor) -> Panel {
        let triangles = Triangles::of_mesh(&new.points, &new.elements);
        let values: Vec<f64> = new.velocity.iter().map(|v| v[1]).collect();
        let scale = self.speeds();
        let (words, about) = match method {
            RemeshMethod::Immersed => (
                ("velocity-immersed", "The same on the immersed mesh"),
                "The velocity transferred to the mesh that was cut out; masses, momentum and centre of mass are kept.",
            ),
            RemeshMethod::Retained => (
                ("velocity-retained", "The same on a mesh that retains old nodes"),
                "The other method from the same state: good nodes and the whole surface stay, points of the quadtree \
                    fill the rest.",
            ),
        };
        self.panel(words, Some(scale), about, |drawing| {
            smooth(drawing, &triangles, &values, &scale);
            edges(drawing, &triangles);
        })
    }

    /// The scale of vertical velocities: symmetric, for all meshes the same.
    fn speeds(&self) -> Scale {
        let most = self.shown.frame.velocities.iter().map(|v| v.z.abs()).fold(0.0, f64::max);
        Scale { low: -most, high: most, unit: "m/s", map: &SIGNED }
    }

    fn outline(&self, drawing: &mut Drawing) {
        let pen = Pen { width: 1.6, strength: 1.0, colour: INK };
        self.outline.iter().for_each(|ends| drawing.line(*ends, &pen));
    }
}

/// The whole of a mesh, and an eighth of it about an element.
fn windows(mesh: &Triangles, element: usize) -> [Window; 2] {
    let ends = |axis: usize| {
        let values = mesh.points.iter().map(|p| p[axis]);
        values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
    };
    let [(left, right), (low, high)] = [ends(0), ends(1)];
    let half = 0.56 * (right - left).max(high - low);
    let [a, b, c] = mesh.at(element);
    let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
    [Window { centre: [0.5 * (left + right), 0.5 * (low + high)], half }, Window { centre: middle, half: 0.125 * half }]
}

/// Fills each triangle with a colour.
fn flat(drawing: &mut Drawing, triangles: &Triangles, colour: impl Fn(usize) -> Colour) {
    for triangle in 0..triangles.corners.len() {
        let colour = colour(triangle);
        drawing.fill(triangles.at(triangle), |_| colour);
    }
}

/// Fills triangles by values at their points, linear in between.
fn smooth(drawing: &mut Drawing, triangles: &Triangles, values: &[f64], scale: &Scale) {
    for (triangle, corners) in triangles.corners.iter().enumerate() {
        let ends = corners.map(|p| values[p]);
        let value = |shares: [f64; 3]| shares.iter().zip(ends).map(|(share, value)| share * value).sum();
        drawing.fill(triangles.at(triangle), |shares| scale.colour(value(shares)));
    }
}

/// Draws all edges once.
fn edges(drawing: &mut Drawing, triangles: &Triangles) {
    let edges = triangles.edges();
    let mut lengths: Vec<f64> = edges.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).collect();
    lengths.sort_by(f64::total_cmp);
    let pen = thin(drawing, lengths.get(lengths.len() / 2).copied().unwrap_or(0.0));
    for ends in &edges {
        drawing.line(*ends, &pen);
    }
}

/// A pen for edges of this length: finer and paler where they are a few pixels long.
fn thin(drawing: &Drawing, length: f64) -> Pen {
    let pixels = drawing.pixels(length);
    Pen { width: (0.06 * pixels).clamp(0.67, 1.33), strength: (0.03 * pixels).clamp(0.2, 0.75), colour: INK }
}
