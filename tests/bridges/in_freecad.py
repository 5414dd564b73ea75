# SPDX-License-Identifier: Apache-2.0
# What FreeCAD makes of the file KNURL_FILE: "knurl SOLIDS FACES VALID VOLUME". Run by freecadcmd, which imports it: a file
# called freecad.py would be taken for its own module.
import os

import FreeCAD
import Import

document = FreeCAD.newDocument()
Import.insert(os.environ["KNURL_FILE"], document.Name)
shapes = [o.Shape for o in document.Objects if o.TypeId.startswith("Part::")]
print(
    "\nknurl",
    sum(len(s.Solids) for s in shapes),
    sum(len(s.Faces) for s in shapes),
    int(all(s.isValid() for s in shapes)),
    "%.17g" % sum(s.Volume for s in shapes),
    flush=True,
)
