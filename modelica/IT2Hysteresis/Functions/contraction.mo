within IT2Hysteresis.Functions;
function contraction "Does the model contract everywhere in its range?"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q1[size(s1, 1)](each final unit="1") "Coefficients of y_{k-1}, q_l1";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length q3[size(s1, 1)] "Constants, q_l3";
  input Modelica.Units.SI.Length yMin "Lower end of the range";
  input Modelica.Units.SI.Length yMax "Upper end of the range";
  output Real largest[2] "Largest |dy_k/dy_{k-1}| at rest, and the displacement in m where it is";
protected
  constant Integer grid=256 "Intervals of a grid over the range";
  constant Integer near=2 "Lower deviations to either side of a rule's centre: a narrow rule would hide in the grid";
  Modelica.Units.SI.Length y "Displacement";
  Real rest[4] "The model at rest there";
  Real most=-1 "Largest until now";
  Modelica.Units.SI.Length place=yMin "Where it is";
algorithm
  for i in 0:grid loop
    y := min(yMin + i*(yMax - yMin)/grid, yMax);
    rest := IT2Hysteresis.Functions.linearisation(s1, s2, c, q1, q2, q3, y);
    if not abs(rest[4]) <= most then
      most := abs(rest[4]);
      place := y;
    end if;
  end for;
  for l in 1:size(s1, 1) loop
    for i in -near:near loop
      y := min(max(c[l] + i*s1[l], yMin), yMax);
      rest := IT2Hysteresis.Functions.linearisation(s1, s2, c, q1, q2, q3, y);
      if not abs(rest[4]) <= most then
        most := abs(rest[4]);
        place := y;
      end if;
    end for;
  end for;
  largest := {most,place};
  annotation (Documentation(info="<html>
<p>
What <a href=\"modelica://IT2Hysteresis.Functions.check\">check</a> says of it: below 1, a wrong initial displacement is
forgotten; from 1 on, a free run diverges.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end contraction;
