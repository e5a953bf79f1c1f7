"""Reads a dense field file with SimpleITK (.nrrd, .mhd) or VTK (.vti) and prints, in the field's
order, where its first and last samples are, then writes its samples as they lie to a file.

SPDX-License-Identifier: MPL-2.0
"""
import sys

path, samples = sys.argv[1:]
if path.endswith(".vti"):
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLImageDataReader()
    reader.SetFileName(path)
    reader.Update()
    image = reader.GetOutput()
    corners = [image.GetPoint(0), image.GetPoint(image.GetNumberOfPoints() - 1)]
    values = vtk_to_numpy(image.GetPointData().GetScalars())
else:
    import SimpleITK

    image = SimpleITK.ReadImage(path)
    last = [int(n) - 1 for n in image.GetSize()]
    corners = [image.TransformIndexToPhysicalPoint([0, 0, 0]),
               image.TransformIndexToPhysicalPoint(last)]
    values = SimpleITK.GetArrayFromImage(image)
assert values.dtype == "float32"
values.tofile(samples)
print(*(repr(float(x)) for corner in corners for x in corner))
