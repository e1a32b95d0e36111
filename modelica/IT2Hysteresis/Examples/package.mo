within IT2Hysteresis;
package Examples "Examples"
  extends Modelica.Icons.ExamplesPackage;
  annotation (Documentation(info="<html>
<p>
Models that simulate as they are and show the library at work. Each has figures that tools which know the standard's
figure annotations plot by themselves. <code>Resources/Reference</code> holds results of a few signals of each, to compare with.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Examples;
