within IT2Hysteresis.Functions;
function coreRest "Displacement at which the model rests at a voltage"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Voltage x "Voltage at rest, x_e";
  input Real lower[4] "Lower end of the range, of linearisation";
  input Real upper[4] "Upper end of the range, of linearisation";
  output Modelica.Units.SI.Length y "Displacement at rest, y_e";
protected
  constant Integer halvings=54 "Of the range, to the last digit";
  Modelica.Units.SI.Length low=lower[1] "The displacement is not below";
  Modelica.Units.SI.Length high=upper[1] "It is not above";
  Modelica.Units.SI.Length middle "Of the two";
algorithm
  for i in 1:halvings loop
    middle := (low + high)/2;
    if IT2Hysteresis.Functions.inverse(s1, s2, c, q1, q2, q3, middle, middle) > x then
      high := middle;
    else
      low := middle;
    end if;
  end for;
  if x < lower[2] then
    y := lower[1] + lower[3]*(x - lower[2])/(1 - lower[4]);
  elseif x > upper[2] then
    y := upper[1] + upper[3]*(x - upper[2])/(1 - upper[4]);
  else
    y := (low + high)/2;
  end if;
  annotation (Documentation(info="<html>
<p>
The fixed point y = y<sub>k</sub> = y<sub>k-1</sub> of <a href=\"modelica://IT2Hysteresis.Functions.core\">core</a> at a constant voltage,
by halving the range: where the model contracts, the voltage at rest rises with the displacement.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end coreRest;
