within IT2Hysteresis.Functions.Effects;
function resonanceCoefficients "Coefficients of the mechanical resonance"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Frequency f "Undamped natural frequency";
  input Real D(unit="1") "Damping, of critical";
  input Real z(unit="1") "Sampling zero, above -1 and at most 0";
  input Modelica.Units.SI.Time Ts "Sample time";
  output Real a[4](each unit="1") "Coefficients a1, a2, b0, b1";
protected
  Real angle=2*Modelica.Constants.pi*f*Ts;
  Real radius=exp(-D*angle);
  Real a1=2*radius*cos(angle*sqrt(1 - D^2));
  Real a2=-radius^2;
  Real b0=(1 - a1 - a2)/(1 - z);
algorithm
  a := {a1,a2,b0,-z*b0};
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
a = Functions.Effects.<strong>resonanceCoefficients</strong>(f, D, z, Ts);
</pre>
<h4>Description</h4>
<p>
The poles are those of the continuous oscillator: a<sub>1</sub> = 2 &#961; cos(&#969; T<sub>s</sub> &#8730;(1 - D<sup>2</sup>)),
a<sub>2</sub> = -&#961;<sup>2</sup> with &#961; = exp(-D &#969; T<sub>s</sub>). Without a resonance (f = 0) both cancel in
<a href=\"modelica://IT2Hysteresis.Functions.Effects.resonance\">resonance</a>, which is then not used.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end resonanceCoefficients;
