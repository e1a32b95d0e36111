within IT2Hysteresis.Functions.Effects;
function hum "Reading that a line adds"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length A "Amplitude";
  input Modelica.Units.SI.Frequency f "Frequency";
  input Modelica.Units.SI.Angle phi "Phase at time 0";
  input Modelica.Units.SI.Time t "Time";
  output Modelica.Units.SI.Length offset "Reading that is added";
algorithm
  offset := A*sin(2*Modelica.Constants.pi*f*t + phi);
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
offset = Functions.Effects.<strong>hum</strong>(A, f, phi, t);
</pre>
<h4>Description</h4>
<p>A sin(2 &#960; f t<sub>k</sub> + &#966;) is added to the reading.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end hum;
