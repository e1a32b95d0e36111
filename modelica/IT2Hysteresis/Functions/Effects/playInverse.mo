within IT2Hysteresis.Functions.Effects;
function playInverse "Inverse of the Prandtl-Ishlinskii operator"
  extends Modelica.Icons.Function;
  input Modelica.Units.SI.Voltage r[:] "Thresholds r_j, rising";
  input Real w[size(r, 1)](each unit="1") "Weights w_j";
  input Modelica.Units.SI.Voltage pPrevious[size(r, 1)] "Play operators at the tick before, p_j,k-1";
  input Modelica.Units.SI.Voltage h "Output at this tick, h_k";
  output Modelica.Units.SI.Voltage x "Input at this tick, x_k";
protected
  Integer n=size(r, 1) "Number of operators";
  Modelica.Units.SI.Voltage rest "h without what the operators that stay contribute";
  Real side "1 if the input rises, -1 if it falls";
  Real slope "dh/dx on the segment";
  Modelica.Units.SI.Voltage corner "Where the next operator begins to move";
  Boolean walking "The segment that holds h is not yet reached";
algorithm
  rest := h - w*pPrevious;
  x := rest;
  slope := 1;
  walking := true;
  side := 1;
  for j in 1:n loop
    if j == 1 then
      side := if rest > pPrevious[1] then 1 else -1;
    end if;
    corner := pPrevious[j] + side*r[j];
    walking := walking and side*(x - corner) > 0;
    if walking then
      rest := rest + w[j]*corner;
      slope := slope + w[j];
      x := rest/slope;
    end if;
  end for;
  annotation (Documentation(info="<html>
<h4>Syntax</h4>
<pre>
x = Functions.Effects.<strong>playInverse</strong>(r, w, pPrevious, h);
</pre>
<h4>Description</h4>
<p>
h rises with x, piecewise linearly: beyond every corner p<sub>j</sub> &#177; r<sub>j</sub> one operator more moves along. The function
walks from the segment in which none moves to the one that holds h, over n + 1 segments at most. Operators move in
the order of their thresholds, and 1 + w<sub>1</sub> + ... + w<sub>j</sub> is positive for every j.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end playInverse;
