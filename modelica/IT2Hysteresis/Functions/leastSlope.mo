within IT2Hysteresis.Functions;
function leastSlope "Can the model be inverted everywhere in its range?"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Length s1[:] "Deviations of the lower memberships, s_l1";
  input Modelica.Units.SI.Length s2[size(s1, 1)] "Deviations of the upper memberships, s_l2";
  input Modelica.Units.SI.Length c[size(s1, 1)] "Centres of the antecedents, c_l";
  input Real q2[size(s1, 1)](each final unit="m/V") "Coefficients of x_k, q_l2";
  input Modelica.Units.SI.Length yMin "Lower end of the range";
  input Modelica.Units.SI.Length yMax "Upper end of the range";
  output Real least[2] "dy_k/dx_k in m/V at the first point where it is not positive, or at the last; that point in m";
protected
  constant Integer grid=256 "Intervals of a grid over the range";
  constant Integer near=2 "Lower deviations to either side of a rule's centre: a narrow rule would hide in the grid";
  Modelica.Units.SI.Length y "Displacement";
  Real k "dy_k/dx_k there";
  Real found=1 "The last, until one is not positive";
  Modelica.Units.SI.Length place=yMin "Where it is";
algorithm
  for i in 0:grid loop
    y := min(yMin + i*(yMax - yMin)/grid, yMax);
    k := IT2Hysteresis.Functions.slope(s1, s2, c, q2, y);
    if found > 0 then
      found := k;
      place := y;
    end if;
  end for;
  for l in 1:size(s1, 1) loop
    for i in -near:near loop
      y := min(max(c[l] + i*s1[l], yMin), yMax);
      k := IT2Hysteresis.Functions.slope(s1, s2, c, q2, y);
      if found > 0 then
        found := k;
        place := y;
      end if;
    end for;
  end for;
  least := {found,place};
  annotation (Documentation(info="<html>
<p>What <a href=\"modelica://IT2Hysteresis.Functions.check\">check</a> says of the inverse (30), which divides by this slope.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end leastSlope;
