within IT2Hysteresis.Blocks;
package PureModelica "Plant and inverse without external code"
  extends Modelica.Icons.VariantsPackage;
  annotation (Documentation(info="<html>
<p>
The blocks as the <a href=\"modelica://IT2Hysteresis.UsersGuide.Equations\">equations</a> state them, by the functions of
<a href=\"modelica://IT2Hysteresis.Functions\">Functions</a>. They run in every Modelica tool, and are the reference that
other realisations are compared with.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end PureModelica;
