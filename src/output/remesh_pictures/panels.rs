//! Panels of the remeshing pictures, one per step of the method.

use super::drawing::{LinePen, PictureCanvas, PictureWindow, PlanePoint, RgbColour};
use crate::math::Vector;
use crate::mesh::{NodeId, Simplex};
use crate::output::picture::{AMBER, ColourMap, SIGNED, SPEED, STEP, sections};
use crate::remesh::ImmersionSteps;
use crate::scene::{RemeshMethod, Scene};
use crate::simulation::{PreviewMesh, RemeshPreview};

/// Texts of a panel.
pub(super) struct PanelText {
    /// Prefix of the file names.
    pub name: &'static str,
    /// Title.
    pub title: &'static str,
    /// Description in a sentence.
    pub about: &'static str,
}

/// Panel of one step: a picture of the whole gel and a close-up.
pub(super) struct PicturePanel {
    pub text: PanelText,
    pub scale: Option<PanelScale>,
    pub whole: Vec<u8>,
    pub close: Vec<u8>,
}

/// Colour scale: values, unit and colour map.
#[derive(Clone, Copy)]
pub(super) struct PanelScale {
    pub low: f64,
    pub high: f64,
    pub unit: &'static str,
    pub map: &'static ColourMap,
}

impl PanelScale {
    fn colour(&self, value: f64) -> RgbColour {
        self.map.at((value - self.low) / (self.high - self.low).max(f64::MIN_POSITIVE))
    }
}

const LINE_COLOUR: RgbColour = [24, 28, 36];
const BODY_COLOUR: RgbColour = [150, 156, 168];
const CUT_COLOUR: RgbColour = [224, 122, 118];
const OUTSIDE_COLOUR: RgbColour = [255; 3];

/// Triangulation for drawing.
struct DrawnTriangles {
    points: Vec<PlanePoint>,
    corners: Vec<[usize; 3]>,
}

/// Data common to all panels of a remeshing.
struct PanelSource<'a> {
    preview: &'a RemeshPreview,
    old: DrawnTriangles,
    /// Boundary edges of the old mesh.
    outline: Vec<[PlanePoint; 2]>,
    bodies: Vec<Vec<PlanePoint>>,
    windows: [PictureWindow; 2],
}

/// Returns the panels in order.
pub(super) fn panels(preview: &RemeshPreview, scene: &Scene) -> Vec<PicturePanel> {
    let source = PanelSource::new(preview, scene);
    let mut panels = vec![source.distorted_mesh(), source.curvature_indicator(), source.target_sizes()];
    if let Ok(steps) = &preview.trial.steps {
        panels.extend([
            source.quadtree_cells(steps),
            source.delaunay_triangulation(steps),
            source.signed_distance(steps),
        ]);
        panels.extend([source.immersed_mesh(steps), source.carved_mesh(steps)]);
    }
    panels.push(source.velocity_before());
    panels.extend(
        preview.trial.successors.iter().filter_map(|(method, new)| Some(source.velocity(*method, new.as_ref().ok()?))),
    );
    panels
}

impl DrawnTriangles {
    fn of(points: &[Vector<2>], corners: Vec<[usize; 3]>) -> Self {
        Self { points: points.iter().map(|p| [p[0], p[1]]).collect(), corners }
    }

    fn of_mesh(points: &[Vector<2>], elements: &[Simplex]) -> Self {
        Self::of(points, elements.iter().map(|e| [e[0], e[1], e[2]].map(NodeId::index)).collect())
    }

    fn at(&self, triangle: usize) -> [PlanePoint; 3] {
        self.corners[triangle].map(|p| self.points[p])
    }

    /// Returns every edge once.
    fn edges(&self) -> Vec<[PlanePoint; 2]> {
        let sides = self.corners.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let mut pairs: Vec<[usize; 2]> = sides.map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.into_iter().map(|pair| pair.map(|p| self.points[p])).collect()
    }
}

impl<'a> PanelSource<'a> {
    fn new(preview: &'a RemeshPreview, scene: &Scene) -> Self {
        let frame = &preview.frame;
        let points: Vec<PlanePoint> = frame.points.iter().map(|p| [p.x, p.z]).collect();
        let corners = frame.cells.nodes.iter().map(|nodes| [0, 1, 2].map(|k| nodes[k] as usize)).collect();
        let outline = frame.cells.facets.iter().map(|f| [f[0], f[1]].map(|node| points[node as usize])).collect();
        let old = DrawnTriangles { points, corners };
        let worst = (0..preview.trial.shapes.len())
            .min_by(|a, b| preview.trial.shapes[*a].total_cmp(&preview.trial.shapes[*b]))
            .unwrap_or(0);
        let windows = windows(&old, worst);
        Self { preview, old, outline, bodies: sections(frame, scene), windows }
    }

    /// Returns a panel drawn by `draw`, with the bodies in the background.
    fn panel(&self, text: PanelText, scale: Option<PanelScale>, draw: impl Fn(&mut PictureCanvas)) -> PicturePanel {
        let [whole, close] = self.windows.map(|window| {
            let mut drawing = PictureCanvas::new(window);
            for body in &self.bodies {
                (2..body.len()).for_each(|i| drawing.fill([body[0], body[i - 1], body[i]], |_| BODY_COLOUR));
            }
            draw(&mut drawing);
            drawing.png()
        });
        PicturePanel { text, scale, whole, close }
    }

    fn distorted_mesh(&self) -> PicturePanel {
        let scale = PanelScale { low: 0.0, high: 1.0, unit: "", map: &STEP };
        self.panel(
            PanelText {
                name: "distorted",
                title: "The distorted mesh",
                about: "The old mesh, coloured by element quality: 1 is equilateral, 0 degenerate.",
            },
            Some(scale),
            |drawing| {
                fill_triangles(drawing, &self.old, |e| scale.colour(self.preview.trial.shapes[e]));
                draw_edges(drawing, &self.old);
            },
        )
    }

    fn curvature_indicator(&self) -> PicturePanel {
        let scale = PanelScale { low: 0.0, high: 90.0, unit: "°", map: &SPEED };
        self.panel(
            PanelText {
                name: "indicator",
                title: "Curvature indicator",
                about: "The greatest angle between the graphs of \
            displacement or velocity over an element and over its neighbours.",
            },
            Some(scale),
            |drawing| {
                fill_triangles(drawing, &self.old, |e| scale.colour(self.preview.trial.bend[e].to_degrees()));
            },
        )
    }

    fn target_sizes(&self) -> PicturePanel {
        let size = &self.preview.trial.size;
        let low = size.iter().copied().fold(f64::MAX, f64::min);
        let high = size.iter().copied().fold(0.0, f64::max);
        let scale = PanelScale { low, high, unit: "m", map: &STEP };
        self.panel(
            PanelText {
                name: "sizes",
                title: "Target element sizes",
                about: "Element sizes from the curvature indicator, the distance from the body and the limit of \
                     growth.",
            },
            Some(scale),
            |drawing| {
                fill_interpolated(drawing, &self.old, size, &scale);
            },
        )
    }

    fn quadtree_cells(&self, steps: &ImmersionSteps) -> PicturePanel {
        self.panel(
            PanelText {
                name: "quadtree",
                title: "The quadtree",
                about: "A balanced quadtree over the square around the gel: cells that \
            intersect the gel are no larger than the target sizes in them.",
            },
            None,
            |drawing| {
                fill_triangles(drawing, &self.old, |_| AMBER);
                let pen = edge_pen(drawing, steps.cells.iter().map(|cell| cell.edge).fold(f64::MAX, f64::min));
                for cell in &steps.cells {
                    let [x, z, half] = [cell.middle[0], cell.middle[1], 0.5 * cell.edge];
                    let corners = [[x - half, z - half], [x + half, z - half], [x + half, z + half]];
                    drawing.line([corners[0], corners[1]], &pen);
                    drawing.line([corners[1], corners[2]], &pen);
                }
            },
        )
    }

    fn delaunay_triangulation(&self, steps: &ImmersionSteps) -> PicturePanel {
        let triangles = DrawnTriangles::of(&steps.background.points, steps.background.triangles.clone());
        self.panel(
            PanelText {
                name: "delaunay",
                title: "Delaunay triangulation of the cell centres",
                about: "The triangulation of the cell centres does not depend on the boundary of the gel.",
            },
            None,
            |drawing| {
                fill_triangles(drawing, &self.old, |_| AMBER);
                draw_edges(drawing, &triangles);
            },
        )
    }

    fn signed_distance(&self, steps: &ImmersionSteps) -> PicturePanel {
        let triangles = DrawnTriangles::of(&steps.background.points, steps.background.triangles.clone());
        let reach = 2.0 * self.windows[1].half;
        let scale = PanelScale { low: -reach, high: reach, unit: "m", map: &SIGNED };
        self.panel(
            PanelText {
                name: "distance",
                title: "Signed distance",
                about: "The distance of the points from the boundary of \
            the gel and its linear interpolant, negative inside the gel.",
            },
            Some(scale),
            |drawing| {
                fill_interpolated(drawing, &triangles, &steps.distance, &scale);
                draw_edges(drawing, &triangles);
                self.outline(drawing);
            },
        )
    }

    fn immersed_mesh(&self, steps: &ImmersionSteps) -> PicturePanel {
        let immersed = &steps.immersed;
        let triangles = DrawnTriangles::of(&immersed.points, immersed.triangles.clone());
        let has = |e: usize, is: &dyn Fn(f64) -> bool| triangles.corners[e].iter().any(|p| is(immersed.distance[*p]));
        self.panel(
            PanelText {
                name: "immersed",
                title: "The gel immersed in the triangulation",
                about: "Points nearer to the boundary than 0.3 of a cell \
            are moved onto it (dots); amber triangles are inside, red triangles are cut.",
            },
            None,
            |drawing| {
                fill_triangles(drawing, &triangles, |e| match (has(e, &|d| d > 0.0), has(e, &|d| d < 0.0)) {
                    (true, true) => CUT_COLOUR,
                    (true, false) => OUTSIDE_COLOUR,
                    (false, _) => AMBER,
                });
                draw_edges(drawing, &triangles);
                self.outline(drawing);
                let pen = LinePen {
                    width: (0.0035 * drawing.pixels(2.0 * self.windows[0].half)).min(5.0),
                    strength: 1.0,
                    colour: LINE_COLOUR,
                };
                let snapped = immersed.points.iter().zip(&immersed.distance).filter(|(_, distance)| **distance == 0.0);
                snapped.for_each(|(p, _)| drawing.dot([p[0], p[1]], &pen));
            },
        )
    }

    fn carved_mesh(&self, steps: &ImmersionSteps) -> PicturePanel {
        let triangles = DrawnTriangles::of_mesh(&steps.proposal.position, &steps.proposal.elements);
        self.panel(
            PanelText {
                name: "carved",
                title: "The carved mesh",
                about: "Outside triangles are removed, triangles that \
            the boundary crosses are cut, and quadrilaterals are divided by their better diagonal.",
            },
            None,
            |drawing| {
                fill_triangles(drawing, &triangles, |_| AMBER);
                draw_edges(drawing, &triangles);
            },
        )
    }

    fn velocity_before(&self) -> PicturePanel {
        let values: Vec<f64> = self.preview.frame.velocities.iter().map(|v| v.z).collect();
        let scale = self.velocity_scale();
        self.panel(
            PanelText {
                name: "velocity-before",
                title: "Vertical velocity on the old mesh",
                about: "The field before its transfer.",
            },
            Some(scale),
            |drawing| {
                fill_interpolated(drawing, &self.old, &values, &scale);
                draw_edges(drawing, &self.old);
            },
        )
    }

    fn velocity(&self, method: RemeshMethod, new: &PreviewMesh) -> PicturePanel {
        let triangles = DrawnTriangles::of_mesh(&new.points, &new.elements);
        let values: Vec<f64> = new.velocity.iter().map(|v| v[1]).collect();
        let scale = self.velocity_scale();
        let text = match method {
            RemeshMethod::Immersed => PanelText {
                name: "velocity-immersed",
                title: "Vertical velocity on the immersed mesh",
                about: "The velocity transferred to the carved mesh; mass, momentum and centre of mass are \
                        conserved.",
            },
            RemeshMethod::Local => PanelText {
                name: "velocity-local",
                title: "Vertical velocity on the locally remeshed mesh",
                about: "Local remeshing of the same state: only the elements that hinder the step are replaced.",
            },
        };
        self.panel(text, Some(scale), |drawing| {
            fill_interpolated(drawing, &triangles, &values, &scale);
            draw_edges(drawing, &triangles);
        })
    }

    /// Returns the scale of vertical velocities, symmetric and common to all meshes.
    fn velocity_scale(&self) -> PanelScale {
        let most = self.preview.frame.velocities.iter().map(|v| v.z.abs()).fold(0.0, f64::max);
        PanelScale { low: -most, high: most, unit: "m/s", map: &SIGNED }
    }

    fn outline(&self, drawing: &mut PictureCanvas) {
        let pen = LinePen { width: 1.6, strength: 1.0, colour: LINE_COLOUR };
        self.outline.iter().for_each(|ends| drawing.line(*ends, &pen));
    }
}

/// Returns a window on the whole mesh, and a window of an eighth of its size about an element.
fn windows(mesh: &DrawnTriangles, element: usize) -> [PictureWindow; 2] {
    let ends = |axis: usize| {
        let values = mesh.points.iter().map(|p| p[axis]);
        values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
    };
    let [(left, right), (low, high)] = [ends(0), ends(1)];
    let half = 0.56 * (right - left).max(high - low);
    let [a, b, c] = mesh.at(element);
    let middle = [0, 1].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0);
    [
        PictureWindow { centre: [0.5 * (left + right), 0.5 * (low + high)], half },
        PictureWindow { centre: middle, half: 0.125 * half },
    ]
}

/// Fills each triangle with a colour.
fn fill_triangles(drawing: &mut PictureCanvas, triangles: &DrawnTriangles, colour: impl Fn(usize) -> RgbColour) {
    for triangle in 0..triangles.corners.len() {
        let colour = colour(triangle);
        drawing.fill(triangles.at(triangle), |_| colour);
    }
}

/// Fills triangles with linearly interpolated nodal values.
fn fill_interpolated(drawing: &mut PictureCanvas, triangles: &DrawnTriangles, values: &[f64], scale: &PanelScale) {
    for (triangle, corners) in triangles.corners.iter().enumerate() {
        let ends = corners.map(|p| values[p]);
        let value = |shares: [f64; 3]| shares.iter().zip(ends).map(|(share, value)| share * value).sum();
        drawing.fill(triangles.at(triangle), |shares| scale.colour(value(shares)));
    }
}

/// Draws every edge once.
fn draw_edges(drawing: &mut PictureCanvas, triangles: &DrawnTriangles) {
    let edges = triangles.edges();
    let mut lengths: Vec<f64> = edges.iter().map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).collect();
    lengths.sort_by(f64::total_cmp);
    let pen = edge_pen(drawing, lengths.get(lengths.len() / 2).copied().unwrap_or(0.0));
    for ends in &edges {
        drawing.line(*ends, &pen);
    }
}

/// Returns a pen for edges of this length; edges of a few pixels get a thin and pale pen.
fn edge_pen(drawing: &PictureCanvas, length: f64) -> LinePen {
    let pixels = drawing.pixels(length);
    LinePen {
        width: (0.06 * pixels).clamp(0.67, 1.33),
        strength: (0.03 * pixels).clamp(0.2, 0.75),
        colour: LINE_COLOUR,
    }
}
