within IT2Hysteresis.UsersGuide;
class Contact "Contact"
  extends Modelica.Icons.Contact;
  annotation (DocumentationClass=true, Documentation(info="<html>
<p>
The library is a part of it2hys and is maintained by the it2hys developers. Questions, errors and wishes are welcome as
issues of the it2hys repository, where the library is in the folder <code>modelica</code>. A report that helps names the tool and its version, that of
the Modelica Standard Library, and holds the smallest model that shows the error.
</p>
<p>
Copyright (c) 2026, the it2hys developers. The library is licensed under the BSD 2-Clause License.
</p>
</html>", revisions="<html>
<ul>
<li><em>Version 0.1.0:</em> first version.</li>
</ul>
</html>"));
end Contact;
