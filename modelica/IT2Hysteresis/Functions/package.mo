within IT2Hysteresis;
package Functions "The model's equations"
  extends Modelica.Icons.FunctionsPackage;
  annotation (Documentation(info="<html>
<p>
The <a href=\"modelica://IT2Hysteresis.UsersGuide.Equations\">equations</a> of the model, with the paper's symbols. The rules
are given as vectors of length L; y<sub>k-1</sub> is <code>yPrevious</code>.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Functions;
