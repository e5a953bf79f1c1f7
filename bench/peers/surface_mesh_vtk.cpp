// The surface by VTK's flying edges.
// SPDX-License-Identifier: MPL-2.0
#include "peers/peer_frame.h"
#include "peers/surface_mesh.h"

#include <vtkCellArray.h>
#include <vtkCellArrayIterator.h>
#include <vtkDataArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>

namespace isocast {

namespace {

std::vector<Eigen::Vector3f> copied(vtkDataArray& array) {
    std::vector<Eigen::Vector3f> vectors;
    for (vtkIdType i = 0; i < array.GetNumberOfTuples(); ++i) {
        const double* v = array.GetTuple3(i);
        vectors.emplace_back(float(v[0]), float(v[1]), float(v[2]));
    }
    return vectors;
}

} // namespace

SurfaceMesh extract_surface(const SparseField& field) {
    const IndexBox box = field.extent();
    const Vec3d origin = field.space().to_world(Vec3d::Zero());
    const double voxel = field.space().voxel_size_world();
    vtkNew<vtkImageData> image;
    image->SetExtent(box.lo.x(), box.hi.x() - 1, box.lo.y(), box.hi.y() - 1, box.lo.z(),
                     box.hi.z() - 1);
    image->SetOrigin(origin.data());
    image->SetSpacing(voxel, voxel, voxel);
    image->AllocateScalars(VTK_FLOAT, 1);
    field.copy_box(box, 0,
                   {static_cast<float*>(image->GetScalarPointer()),
                    static_cast<std::size_t>(box.sample_count())});

    vtkNew<vtkFlyingEdges3D> edges;
    edges->SetInputData(image);
    edges->SetValue(0, 0);
    edges->ComputeNormalsOn();
    edges->ComputeScalarsOff();
    const auto start = std::chrono::steady_clock::now();
    edges->Update();
    const double seconds = seconds_since(start);

    vtkPolyData* surface = edges->GetOutput();
    SurfaceMesh mesh{.points_world = copied(*surface->GetPoints()->GetData()),
                     .normals = copied(*surface->GetPointData()->GetNormals()),
                     .extraction_seconds = seconds,
                     .extractor = "FlyingEdges"};
    const auto cells =
        vtkSmartPointer<vtkCellArrayIterator>::Take(surface->GetPolys()->NewIterator());
    for (cells->GoToFirstCell(); !cells->IsDoneWithTraversal(); cells->GoToNextCell()) {
        vtkIdType count = 0;
        const vtkIdType* corners = nullptr;
        cells->GetCurrentCell(count, corners);
        mesh.triangles.push_back(
            {std::uint32_t(corners[0]), std::uint32_t(corners[1]), std::uint32_t(corners[2])});
    }
    return mesh;
}

} // namespace isocast
