within IT2Hysteresis.Functions.Effects;
function delayedStates "Voltages that the delay remembers after a tick"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage u[:] "Voltages at the ticks before, u_{k-1}, u_{k-2}, ...";
  input Modelica.Units.SI.Voltage x "Voltage at this tick, u_k";
  output Modelica.Units.SI.Voltage uNext[size(u, 1)] "u_k, u_{k-1}, ...";
algorithm
  uNext[1] := x;
  for i in 2:size(u, 1) loop
    uNext[i] := u[i - 1];
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
uNext = Functions.Effects.<strong>delayedStates</strong>(u, x);
</pre>
<h4>Description</h4>
<p>The memory moves on by one tick; the oldest voltage drops out.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end delayedStates;
