within IT2Hysteresis.Functions.Effects;
function slew "Slew limit of the amplifier"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage step "Largest change in one tick, slewRate Ts";
  input Modelica.Units.SI.Voltage yPrevious "Output at the tick before, y_{k-1}";
  input Modelica.Units.SI.Voltage x "Input at this tick, x_k";
  output Modelica.Units.SI.Voltage y "Output at this tick, y_k";
algorithm
  y := min(max(x, yPrevious - step), yPrevious + step);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
y = Functions.Effects.<strong>slew</strong>(step, yPrevious, x);
</pre>
<h4>Description</h4>
<p>
|y<sub>k</sub> - y<sub>k-1</sub>| &#8804; slewRate T<sub>s</sub>. The limit loses information; its inverse is the same function, the
nearest voltage that passes unchanged.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end slew;
