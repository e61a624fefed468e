//! `documentation/index.html`: wiring, frames and limits of the FMU, and all variables.

use super::PackedInterface;
use super::requirement;
use ballistic_gel::fmi2::{self, Causality, Kind, OutputSet, ScalarVariable, Variable};
use ballistic_gel::scene::{Dimension, Scene};
use std::collections::BTreeMap;
use std::fmt::Write as _;

const STYLE: &str = "body{font:16px/1.5 sans-serif;max-width:64rem;margin:2rem auto;padding:0 1rem;color:#222}\
    table{border-collapse:collapse;font-size:.85rem}td,th{border:1px solid #ccc;padding:.2rem .5rem;text-align:left}\
    code{background:#f3f3f3;padding:0 .2rem}th{background:#f3f3f3}";

const WIRING: &str = "\
<h2>Wiring</h2>
<p>Parameter <code>coupling.mode</code> selects the integrator of the motion of the projectile.</p>
<h3>integrated (2, the default)</h3>
<p>The FMU integrates the projectile inside the step, under the contact with the gel and under
<code>projectile.external_force</code> and <code>projectile.external_torque</code>. Wire these two inputs and read
<code>projectile.predicted_*</code>. The kinematic inputs are read only at the step that activates a body. With inputs
that are constant, or change at the same points, the result does not depend on the communication step.</p>
<h3>corrected (3)</h3>
<p>For an importer that owns the body. At the start of each step its <code>projectile.position</code>,
<code>.velocity</code>, <code>.orientation</code> and <code>.angular_velocity</code> replace the state of the FMU; the
energy of the jump is in the account <code>energy.importer</code>. With a constant external force F and torque T over a step of length H,
and J, S and A the outputs <code>contact.impulse</code>, <code>contact.impulse_moment</code> and
<code>contact.angular_impulse</code> after it, the importer reaches the predicted state to round-off with</p>
<p>x<sub>1</sub> = x<sub>0</sub> + v<sub>0</sub> H + &frac12; F H&sup2; / m + S / m<br>
v<sub>1</sub> = v<sub>0</sub> + (F H + J) / m<br>
L<sub>1</sub> = L<sub>0</sub> + T H + A</p>
<p>where L is the angular momentum, and takes <code>projectile.predicted_orientation</code> as its orientation.</p>
<h3>prescribed (1)</h3>
<p>The kinematic inputs prescribe the motion: x(s) = x<sub>0</sub> + v<sub>0</sub> s + &frac12; a s&sup2; within a step,
where a is the first derivative of the velocity input (<code>fmi2SetRealInputDerivatives</code>), or 0.</p>
<h3>Fixed projectile</h3>
<p>If the scene fixes a body (<code>projectile.fixed = true</code>), it has no inputs that would move it.</p>
<h3>Inactive bodies, and domes</h3>
<p>An inactive body (<code>active</code> is false) keeps its position, has no contact and is in no account. When activated,
it starts from its kinematic inputs, in every mode; inside the gel it is refused. A body with the shape <code>dome</code> is the back
face of an armour: a plate with a spherical cap whose height and base radius are the inputs <code>bulge_height</code> and
<code>bulge_radius</code>, with their rates, in every mode. The bulge moves with these rates within the step.
<code>contact.bulge_height_impulse</code> is the generalised impulse on the height: divided by the mass that moves with the
height it is the change of its rate.</p>
<h3>Forces or impulses</h3>
<p>Contact acts by impulses. <code>contact.force</code> and <code>contact.torque</code> are means over the last step:
wire them only for steps of at least <code>coupling.step_min</code>. <code>contact.linear_force</code> carries the
directional derivative by position and velocity and is not for wiring.</p>
";

const FRAMES: &str = "\
<h2>Frames, signs, units</h2>
<p>SI units. The world frame is right-handed with z up; the undeformed entry surface of a block or cylinder is z = 0
at the start, the gel below it. Depths are measured against the block, which moves by <code>block.displacement</code> if
nothing holds it. Orientation is a Hamilton quaternion (w, x, y, z) from the body to the world frame; its norm must be
1 to within 10<sup>-3</sup>. Inertia is in the frame of the body about its centre of mass: xx, yy, zz, xy, xz, yz.
Angular velocity, torque and angular impulse are in the world frame about the centre of mass. Depth is positive into
the gel. Forces and impulses are those on the projectile.</p>
";

const LIMITS: &str = "\
<h2>Limits</h2>
<ul>
<li>A step beyond a defined stop time, or of a length that is not positive and finite, is refused with
<code>fmi2Error</code>. So are numbers that are not finite.</li>
<li>A step that the mesh cannot follow returns <code>fmi2Discard</code> with <code>fmi2Terminated</code> true; the log
gives the element, the time and the remedy. Outputs, states and reset remain available.</li>
<li>A body whose rear end has passed the back face of a block or cylinder has perforated it: <code>projectile.perforated</code>.
<code>scene.stop_after_exit</code> later, once the cavity has begun to shrink and all bodies have left, the gel is taken to be at rest: later
steps only move the bodies in free flight, at no cost.
A step that brings a body back then is refused with <code>fmi2Error</code>; <code>scene.stop_after_exit</code> of <code>never</code>
keeps the gel active.</li>
<li>Times in the log, in <code>history.csv</code>, in the frames and in <code>summary.json</code> count from the start
of the simulation, whatever <code>startTime</code> is; only the last successful time of
<code>fmi2GetRealStatus</code> counts from <code>startTime</code>.</li>
<li>A step so short, or so far from time 0, that double precision loses a millionth of it is refused with
<code>fmi2Error</code>. A step of at most 10<sup>-9</sup> of the time since the start is accepted: it is the round-off that is left
where an importer sums its steps.</li>
<li>Files that can no longer be written once the run is going on are given up with <code>fmi2Warning</code>; the call
itself is done. Two instances cannot write into one folder at a time: the second is refused at
<code>fmi2ExitInitializationMode</code> (where the system can lock a file). Give them different names.</li>
<li>An instance writes into <code>output_directory/</code><i>its name</i><code>/</code>. A new or empty folder is made its own
by a manifest, <code>gelfmu.jsonl</code>, which lists every file; files of an earlier run that are listed there are replaced
once the first record of the new run is written, and nothing else is touched. A folder that is not empty and has no
manifest, a file of yours with the name of a result, and a folder that has the scene of the instance are refused at
<code>fmi2ExitInitializationMode</code>.</li>
<li>Scenes and the files that they name are read up to 1 MiB and 128 MiB; devices and pipes are refused.</li>
<li>Signals are the host's: the FMU changes no disposition. Under a limit of the size of files (<code>ulimit -f</code>) the
system ends a process that does not handle or ignore <code>SIGXFSZ</code>; a host that ignores it gets the warning above
instead, as on a full disk.</li>
<li>A fault inside the FMU returns <code>fmi2Fatal</code> with a line in the log; its language prints another to the
standard error of the process.</li>
<li>The folder <code>resources</code> belongs to this FMU: its GUID is a hash of the model description, the libraries and these
files. An instance is refused where the folder is not given or <code>manifest.json</code> in it has another GUID, and where
one of the files was changed: pack the scene anew instead of editing the unpacked archive. Files that a tool adds are ignored,
and the model description may be rewritten as long as it keeps its GUID. To run another scene without packing it, set the
parameter <code>scene</code> to its absolute path; one that needs an input that is not listed below is refused.</li>
<li>A parameter is fixed once initialization is over. One that differs from its start overrides the scene; one that is
equal to its start leaves another <code>scene</code> as it is.</li>
<li>A state can be restored in another process. It does not hold <code>threads</code> and
<code>output_directory</code>. Restored to before the run, the files of the run are completed; to a moment of it, they
are cut there.</li>
<li>Every call computes with rounding to nearest, all floating-point traps masked and subnormal numbers kept, and puts the
floating-point environment of the importer back; the logger is called in that of the importer (x86-64 and AArch64).</li>
<li>Memory: building the scene, a step that may remesh, a state, and the writing of results reserve what they need
before they begin. If the machine, the container or the process (RLIMIT_AS) has less, the call is refused with
<code>fmi2Error</code>; the log says how much was needed and how much is available; the call can be repeated. A reserve is address
space, not touched unless it is needed: at least 32 MiB while such a call runs, and 1 MiB as long as there is an instance. Two cases
end the process all the same: a phase that needs more than its estimate when nothing is left, and a container whose
limit is exceeded by another process in the meantime.</li>
<li>Stack: a thread that calls needs 96 KiB of it. Worker threads (<code>threads</code> other than 1) have 2 MiB each.</li>
<li><code>fork</code>: the child of a fork has no worker threads, and a call that waits for them does not return. Fork before
instances are made, or leave <code>threads</code> at 1 and use an instance in one of the two processes only.</li>
<li>Input derivatives are of order 1, hold for one step and act on the velocity (prescribed), on the external force and
torque, and on the rates of height and radius of a dome. Output derivatives are of order 1, from what acted in the last step.</li>
</ul>
";

/// Makes the page of an FMU with this packed scene and this interface.
pub fn page(scene: &Scene, interface: &PackedInterface, libraries: &BTreeMap<String, Vec<u8>>) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{model}</title>\n\
         <style>{STYLE}</style></head><body>\n<h1>{model} {version}</h1>\n<p>{about}.</p>\n",
        model = fmi2::MODEL,
        version = env!("CARGO_PKG_VERSION"),
        about = escaped(env!("CARGO_PKG_DESCRIPTION")),
    );
    page += &packed(scene);
    page += WIRING;
    page += FRAMES;
    page += LIMITS;
    page += &requirement::paragraph(libraries);
    page += &table(interface);
    page += "<p><a href=\"licenses/license.html\">Licences</a> of this library, of every crate linked into it and of the standard library of its language. <a href=\"externalDependencies.html\">What it needs</a> of the system that loads it.</p>\n";
    page += "</body></html>\n";
    page
}

/// Makes `externalDependencies.html` (FMI 2.0.5).
pub fn external_dependencies(libraries: &BTreeMap<String, Vec<u8>>) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>External dependencies</title>\n\
         <style>{STYLE}</style></head><body>\n<h1>External dependencies</h1>\n{}\
         <p>Apart from system libraries the FMU needs nothing: no installation, no licence server, no network, no environment \
         variable.</p>\n<p>It reads its folder <code>resources</code> and, if the parameter <code>scene</code> is set, that file and \
         those that it names; it writes where the parameter <code>output_directory</code> says, and nothing if that is \
         empty.</p>\n</body></html>\n",
        requirement::paragraph(libraries)
    )
}

fn packed(scene: &Scene) -> String {
    let space = match scene.scene.dimension {
        Dimension::Planar => {
            "planar: the x-z plane; masses, forces and impulses are for the thickness of the gel. There are no inputs \
             out of the plane"
        }
        Dimension::Axisymmetric => {
            "axisymmetric about z: x is the radius, totals are for the full revolution. There are no inputs off the axis"
        }
        Dimension::Spatial => "spatial",
    };
    format!(
        "<h2>The packed scene</h2>\n<p><b>{}</b>: {}. The scene is {space}. Its end time is {:?} s, its default \
         communication step {:?} s. Its text is in <code>resources/scene.toml</code>.</p>\n",
        escaped(&scene.scene.name),
        escaped(&scene.scene.title),
        scene.scene.end_time,
        scene.scene.communication_step,
    )
}

fn table(interface: &PackedInterface) -> String {
    let PackedInterface { ports, outputs, .. } = interface;
    let (fragments, sensors) = (ports.fragments(), ports.sensors());
    let mut rows = String::from("<h2>Variables</h2>\n");
    rows += match outputs {
        OutputSet::Integrated => "<p>The outputs are those for the coupling mode <code>integrated</code>",
        OutputSet::Corrected => {
            "<p>The outputs are those for the coupling modes <code>corrected</code> and <code>prescribed</code>"
        }
        OutputSet::Full => "<p>All that can be an output is one",
    };
    rows += " (<code>gelfmu pack --outputs</code>); whatever else is computed is a local variable and can be read all the same. \
             Inputs that the packed scene cannot use are absent. References are the same in every FMU.</p>\n";
    if fragments > 0 {
        let _ = writeln!(
            rows,
            "<p>This FMU has variables for {fragments} of the fragments of its scene. Fragment i has those that are marked \
             with * and that it can use, named <code>fragment[i].&hellip;</code> without the <code>projectile.</code>, such as \
             <code>fragment[1].depth</code> and <code>fragment[1].contact.impulse[3]</code>; their references are \
             higher by 10000 i.</p>"
        );
    }
    if sensors > 0 {
        let _ = writeln!(
            rows,
            "<p>It has variables for {sensors} of the sensors of its scene: those named <code>sensor.&hellip;</code> below are \
             <code>sensor[i].&hellip;</code>, such as <code>sensor[1].pressure</code>; the references of sensor i are higher by \
             10000 (i &minus; 1). A sensor follows its material point, independently of the mesh.</p>"
        );
    }
    rows += "<table>\n<tr><th>name</th><th>reference</th><th>causality</th><th>type</th><th>unit</th>\
         <th>meaning</th></tr>\n";
    for variable in fmi2::VARIABLES {
        rows += &rows_of(variable, interface);
    }
    rows + "</table>\n"
}

/// Makes the rows of a variable, as the first body or sensor has it: one for all components of the same causality.
fn rows_of(variable: &'static Variable, interface: &PackedInterface) -> String {
    let components = |body: usize| -> Vec<ScalarVariable> {
        ScalarVariable::of(variable, body).filter(|own| interface.ports.include(own)).collect()
    };
    let scalars = (0..=interface.ports.fragments()).map(components).find(|scalars| !scalars.is_empty());
    let scalars = scalars.filter(|_| variable.causality != Causality::Independent).unwrap_or_default();
    scalars
        .chunk_by(|one, next| interface.causality(one) == interface.causality(next))
        .map(|own| row(own, interface))
        .collect()
}

/// Makes the row of components of one causality.
fn row(scalars: &[ScalarVariable], interface: &PackedInterface) -> String {
    let variable = scalars[0].variable;
    let (name, reference) = name_and_reference(scalars);
    let star = if interface.ports.fragments() > 0 && variable.each { " *" } else { "" };
    let description = variable.description().replace(['{', '}'], "").replace('|', ", ");
    let details = if variable.details.is_empty() { String::new() } else { format!(". {}", variable.details) };
    let items = variable.items().iter().map(|item| format!("; {}: {}", item.name, item.description));
    format!(
        "<tr><td><code>{name}</code>{star}</td><td>{reference}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
        causality(interface.causality(&scalars[0])),
        kind(variable),
        variable.unit.unwrap_or_default(),
        escaped(&(description + &details + &items.collect::<String>())),
    )
}

/// Formats name and reference of the components of a variable: as a range if it has all.
fn name_and_reference(scalars: &[ScalarVariable]) -> (String, String) {
    let variable = scalars[0].variable;
    // The rows of sensors stand for each of them.
    let name = if variable.is_of_sensors() { variable.name.to_owned() } else { scalars[0].row_name() };
    let (first, last) = (scalars[0].reference(), scalars[scalars.len() - 1].reference());
    if variable.length == 0 {
        return (name, first.to_string());
    }
    if scalars.len() == variable.size() {
        return (format!("{name}[1..{}]", variable.length), format!("{first}&ndash;{last}"));
    }
    let list = |part: &dyn Fn(&ScalarVariable) -> u32| {
        scalars.iter().map(|scalar| part(scalar).to_string()).collect::<Vec<_>>().join(", ")
    };
    let components = list(&|scalar| scalar.component as u32 + 1);
    (format!("{name}[{components}]"), list(&ScalarVariable::reference))
}

fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Independent => "independent",
        Causality::Parameter => "parameter",
        Causality::CalculatedParameter => "calculated parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    }
}

fn kind(variable: &Variable) -> &'static str {
    match variable.kind {
        Kind::Real => "Real",
        Kind::Integer | Kind::Enumeration => "Integer",
        Kind::Boolean => "Boolean",
        Kind::String => "String",
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballistic_gel::scene;

    #[test]
    fn the_page_names_every_variable_and_the_scene() {
        let scene = scene::read(scene::builtin("sphere-block").unwrap()).unwrap();
        let libraries = BTreeMap::from([("linux64/a.so".to_owned(), b"\0GLIBC_2.4\0".to_vec())]);
        let every =
            PackedInterface { ports: fmi2::VariablePorts::all(), outputs: OutputSet::Full, has_terminals: false };
        let full = page(&scene, &every, &libraries);
        for variable in fmi2::VARIABLES.iter().filter(|variable| variable.causality != Causality::Independent) {
            assert!(full.contains(variable.name), "{}", variable.name);
        }
        let own = page(&scene, &PackedInterface::full(&scene), &libraries);
        assert!(!own.contains("<code>projectile.bulge_height</code>"));
        assert!(own.contains("<code>projectile.external_force[1..3]</code>"));
        let on_axis = scene::read(scene::builtin("fbi-bb").unwrap()).unwrap();
        let on_axis = page(&on_axis, &PackedInterface::full(&on_axis), &libraries);
        assert!(on_axis.contains("<code>projectile.position[3]</code></td><td>102</td>"));
        assert!(own.contains("sphere-block") && !own.contains("{x|y|z}"));
        assert!(own.contains("needs the GNU C library, version 2.4 or later"));
    }
}
