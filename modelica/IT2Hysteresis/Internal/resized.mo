within IT2Hysteresis.Internal;
function resized "A vector made longer or shorter"
  extends Modelica.Icons.Function;
  input Real x[:] "Vector of one element or more";
  input Integer n "Number of elements wanted";
  output Real y[n] "Vector of that length";
algorithm
  for i in 1:n loop
    y[i] := x[min(i, size(x, 1))];
  end for;
  annotation (Documentation(info="<html>
<p>
What is missing is as the last element. A tool computes sizes before a block can say that two vectors of a parameter set differ in length. So the second is made
as long as the first, and the block's check, which comes later, tells the user which vector to mend.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end resized;
