# SPDX-License-Identifier: Apache-2.0
# vtk_eval.py FILE.vtu: prints what VTK makes of each Bezier cell at a few parameters, a line for each cell.
import sys

try:
    import vtkmodules.all as vtk
except ImportError:
    sys.exit(77)
if vtk.vtkVersion().GetVTKMajorVersion() * 100 + vtk.vtkVersion().GetVTKMinorVersion() < 901:
    sys.exit(77)

reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
for c in range(grid.GetNumberOfCells()):
    cell = grid.GetCell(c)
    line = [str(grid.GetCellType(c)), str(int(grid.GetCellData().GetArray("part").GetValue(c)))]
    if grid.GetCellType(c) != vtk.VTK_TRIANGLE:
        for at in ((0.2, 0.3, 0.7), (0.9, 0.15, 0.4), (0.0, 1.0, 0.5)):
            x = [0.0, 0.0, 0.0]
            cell.EvaluateLocation(vtk.reference(0), at, x, [0.0] * cell.GetNumberOfPoints())
            line += ["%.17g" % v for v in x]
    print(" ".join(line))
