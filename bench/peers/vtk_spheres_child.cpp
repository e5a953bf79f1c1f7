// VTK's sphere mapper on one scene, a program of its own because it needs an X display.
//
// vtk_spheres_child SCENE EYE(3) TARGET(3) UP(3) FOV WIDTH HEIGHT REPEATS
// SCENE: a line for each, "x y z radius r g b"
// prints "vtk_child: SETUP_SECONDS FRAME_SECONDS RENDERER" as its last line.
// SPDX-License-Identifier: MPL-2.0
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

/// Points with colours.
struct Points {
    vtkNew<vtkPoints> points;
    vtkNew<vtkUnsignedCharArray> colours;
    vtkNew<vtkPolyData> data;

    Points() {
        colours->SetName("colours");
        colours->SetNumberOfComponents(3);
    }
    void add(const double* p, const double* rgb) {
        points->InsertNextPoint(p);
        double bytes[3];
        for (int i = 0; i < 3; ++i) bytes[i] = std::round(255 * std::pow(rgb[i], 1 / 2.2));
        colours->InsertNextTuple(bytes);
    }
    void finish() {
        vtkNew<vtkCellArray> cells; // without, VTK draws nothing
        for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) cells->InsertNextCell(1, &i);
        data->SetVerts(cells);
        data->SetPoints(points);
        data->GetPointData()->SetScalars(colours);
    }
};

std::string renderer_name(vtkRenderWindow* window) {
    const std::string capabilities = window->ReportCapabilities();
    const std::string key = "OpenGL renderer string:";
    const auto at = capabilities.find(key);
    if (at == std::string::npos) return "unknown renderer";
    const auto begin = capabilities.find_first_not_of(' ', at + key.size());
    return capabilities.substr(begin, capabilities.find('\n', begin) - begin);
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 15) {
        std::fprintf(stderr, "vtk_spheres_child: 14 arguments, please: see its source\n");
        return 1;
    }
    std::array<double, 13> numbers{}; // eye, target, up, fov, width, height, repeats
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = std::atof(argv[i + 2]);
    const int width = int(numbers[10]);
    const int height = int(numbers[11]);
    const int repeats = int(numbers[12]);

    Points spheres;
    vtkNew<vtkFloatArray> radii;
    radii->SetName("radii");
    std::ifstream scene(argv[1]);
    for (std::array<double, 7> v{}; scene >> v[0];) {
        for (std::size_t i = 1; i < v.size(); ++i) scene >> v[i];
        spheres.add(v.data(), &v[4]);
        radii->InsertNextValue(float(v[3]));
    }
    spheres.finish();
    spheres.data->GetPointData()->AddArray(radii);

    vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(1, 1, 1);
    vtkNew<vtkOpenGLSphereMapper> sphere_mapper;
    sphere_mapper->SetInputData(spheres.data);
    sphere_mapper->SetScaleArray("radii");
    vtkNew<vtkActor> sphere_actor;
    sphere_actor->SetMapper(sphere_mapper);
    vtkProperty* property = sphere_actor->GetProperty();
    property->SetAmbient(0.2);
    property->SetDiffuse(0.8);
    property->SetSpecular(0.25);
    property->SetSpecularPower(40);
    renderer->AddActor(sphere_actor);
    vtkCamera* camera = renderer->GetActiveCamera();
    camera->SetPosition(&numbers[0]);
    camera->SetFocalPoint(&numbers[3]);
    camera->SetViewUp(&numbers[6]);
    camera->SetViewAngle(numbers[9]);
    renderer->ResetCameraClippingRange();

    vtkNew<vtkRenderWindow> window;
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetSize(width, height);
    window->AddRenderer(renderer);

    // Reading the picture waits for it. The eye moves a little from frame to frame, as ours does.
    vtkNew<vtkUnsignedCharArray> pixels;
    const auto draw = [&](int frame) {
        camera->SetPosition(numbers[0] + 1e-3 * frame, numbers[1], numbers[2]);
        const auto start = std::chrono::steady_clock::now();
        window->Render();
        window->GetPixelData(0, 0, width - 1, height - 1, 0, pixels);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const double first = draw(0);
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) seconds.push_back(draw(i + 1));
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
    const double frame = seconds[static_cast<std::size_t>(repeats) / 2];
    std::printf("vtk_child: %.6f %.6f %s\n", first - frame, frame, renderer_name(window).c_str());
}
