block Partner "Rigid body that owns its state and is moved by the impulses of the gel: template of a partner"
  // Inputs and outputs have the names of RigidBody.fmu, whose place an FMU of this block takes in a system. The
  // equations are the update of docs/coupling.md, section 3. It happens once in each communication step, in its
  // middle, so that no event coincides with a communication point. The parameter `step` must be the communication
  // step of the importer, and the start values those of the gel's scene. Those below are the ball of `sphere-block`.
  //
  // Checked with the Modelica compiler rumoca 0.10.2: the block moves as templates/partner.py, to round-off
  // (tests/conformance/test_templates.py). An FMU needs another tool: this compiler exports no sampled equations yet.
  //
  // Your own forces go into `own_force` and `own_torque`, constant over a step.

  parameter Real step(unit = "s") = 1e-5 "Communication step";
  parameter Real mass(unit = "kg") = 0.033 "Mass: the gel's effective_mass";
  parameter Real inertia[6](each unit = "kg.m2") = {1.32e-6, 1.32e-6, 1.32e-6, 0.0, 0.0, 0.0}
    "Inertia tensor about the centre of mass in the body frame: xx yy zz xy xz yz";
  parameter Real initial_position[3](each unit = "m") = {0.0, 0.0, 0.010} "Position of the centre of mass";
  parameter Real initial_velocity[3](each unit = "m/s") = {0.0, 0.0, -5.0} "Velocity of the centre of mass";
  parameter Real initial_orientation[4] = {1.0, 0.0, 0.0, 0.0} "Orientation (w, x, y, z)";
  parameter Real initial_angular_velocity[3](each unit = "rad/s") = {0.0, 0.0, 0.0} "Angular velocity, world frame";

  input Real impulse[3](each unit = "N.s", each start = 0.0) "Impulse of the gel in the step";
  input Real angular_impulse[3](each unit = "N.m.s", each start = 0.0) "Angular impulse about the centre of mass";
  input Real impulse_moment[3](each unit = "N.s2", each start = 0.0) "First moment of the impulses about the end";
  input Real predicted_orientation[4](each start = 0.0) "Orientation at the end of the step; zero: not known";
  input Real force[3](each unit = "N", each start = 0.0) "Every other force, constant over the step";
  input Real torque[3](each unit = "N.m", each start = 0.0) "Every other torque, constant over the step";

  output Real position[3](each unit = "m") "Position of the centre of mass";
  output Real velocity[3](each unit = "m/s") "Velocity of the centre of mass";
  output Real orientation[4] "Orientation (w, x, y, z)";
  output Real angular_velocity[3](each unit = "rad/s") "Angular velocity, world frame";
  output Real total_impulse[3](each unit = "N.s") "Sum of the impulses that moved the body";

protected
  discrete Real x[3](start = initial_position, each fixed = true);
  discrete Real v[3](start = initial_velocity, each fixed = true);
  discrete Real q[4](start = initial_orientation, each fixed = true);
  discrete Real sum[3](each start = 0.0, each fixed = true);
  discrete Real l[3](start = rotation(initial_orientation) * tensor * transpose(rotation(initial_orientation))
    * initial_angular_velocity, each fixed = true) "Angular momentum about the centre of mass, world frame";
  parameter Real tensor[3, 3] = [inertia[1], inertia[4], inertia[5]; inertia[4], inertia[2], inertia[6];
    inertia[5], inertia[6], inertia[3]];
  Real own_force[3] = force;
  Real own_torque[3] = torque;

  function rotation "Matrix of a unit quaternion (w, x, y, z)"
    input Real q[4];
    output Real r[3, 3];
  algorithm
    r := [1 - 2 * (q[3] ^ 2 + q[4] ^ 2), 2 * (q[2] * q[3] - q[1] * q[4]), 2 * (q[2] * q[4] + q[1] * q[3]);
      2 * (q[2] * q[3] + q[1] * q[4]), 1 - 2 * (q[2] ^ 2 + q[4] ^ 2), 2 * (q[3] * q[4] - q[1] * q[2]);
      2 * (q[2] * q[4] - q[1] * q[3]), 2 * (q[3] * q[4] + q[1] * q[2]), 1 - 2 * (q[2] ^ 2 + q[3] ^ 2)];
  end rotation;

  function spin "Angular velocity of a body with an orientation, an inertia tensor and an angular momentum"
    input Real q[4];
    input Real tensor[3, 3];
    input Real l[3];
    output Real w[3];
  protected
    Real r[3, 3] = rotation(q);
    Real b[3] = transpose(r) * l "Angular momentum in the body frame";
    Real det = tensor[1, :] * cross(tensor[2, :], tensor[3, :]);
  algorithm
    // Cramer's rule, with the rows of the symmetric tensor.
    w := r * {b * cross(tensor[2, :], tensor[3, :]), b * cross(tensor[3, :], tensor[1, :]),
      b * cross(tensor[1, :], tensor[2, :])} / det;
  end spin;

  function turned "Orientation after a turn with an angular velocity: where the gel predicts none"
    input Real q[4];
    input Real w[3];
    input Real h;
    output Real p[4];
  protected
    Real angle = max(1e-30, sqrt(w * w)) * h;
    Real c = cos(angle / 2);
    Real u[3] = w * h * sin(angle / 2) / angle;
  algorithm
    p := {c * q[1] - u[1] * q[2] - u[2] * q[3] - u[3] * q[4], c * q[2] + u[1] * q[1] + u[2] * q[4] - u[3] * q[3],
      c * q[3] - u[1] * q[4] + u[2] * q[1] + u[3] * q[2], c * q[4] + u[1] * q[3] - u[2] * q[2] + u[3] * q[1]};
  end turned;

equation
  when sample(step / 2, step) then
    x = pre(x) + pre(v) * step + (own_force * step ^ 2 / 2 + impulse_moment) / mass;
    v = pre(v) + (own_force * step + impulse) / mass;
    l = pre(l) + own_torque * step + angular_impulse;
    q = if predicted_orientation * predicted_orientation > 0.0 then predicted_orientation
      else turned(pre(q), spin(pre(q), tensor, pre(l)), step);
    sum = pre(sum) + impulse;
  end when;
  position = x;
  velocity = v;
  orientation = q;
  angular_velocity = spin(q, tensor, l);
  total_impulse = sum;
end Partner;
