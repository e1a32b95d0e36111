within IT2Hysteresis;
package Icons "Icons"
  extends Modelica.Icons.IconsPackage;
  annotation (Documentation(info="<html>
<p>Icons of the library's blocks: a hysteresis loop for the plant, the mirrored loop for the inverse.</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Icons;
