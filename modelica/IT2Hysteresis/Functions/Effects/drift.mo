within IT2Hysteresis.Functions.Effects;
function drift "Displacement that drift adds"
  extends Modelica.Icons.Function;
  input Real alpha(unit="m/K") "Displacement per temperature";
  input Modelica.Units.SI.Velocity rate "Displacement per time";
  input Modelica.Units.SI.Temperature T "Temperature";
  input Modelica.Units.SI.Time t "Time";
  output Modelica.Units.SI.Length offset "Displacement that is added";
algorithm
  offset := alpha*(T - 293.15) + rate*t;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
offset = Functions.Effects.<strong>drift</strong>(alpha, rate, T, t);
</pre>
<h4>Description</h4>
<p>
&#945; (T<sub>k</sub> - 293.15 K) + rate t<sub>k</sub> is added to the displacement; the inverse subtracts it.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end drift;
