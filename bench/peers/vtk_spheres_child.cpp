// VTK's sphere and stick mappers on one scene, a program of its own because it needs an X display.
//
// vtk_spheres_child SCENE MASK EYE(3) TARGET(3) UP(3) FOV WIDTH HEIGHT REPEATS
// SCENE: as write_scene() of spheres_peer.cpp writes it
// MASK: written, PGM: the pixels that the first frame covers, before the eye moves
// prints "peer_child: SECONDS RENDERER" as its last line.
// SPDX-License-Identifier: MPL-2.0
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkOpenGLSphereMapper.h>
#include <vtkOpenGLStickMapper.h>
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
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

/// Points with colours and sizes.
struct Points {
    vtkNew<vtkPoints> points;
    vtkNew<vtkUnsignedCharArray> colours;
    vtkNew<vtkFloatArray> sizes;
    vtkNew<vtkPolyData> data;

    Points() {
        colours->SetName("colours");
        colours->SetNumberOfComponents(3);
        sizes->SetName("sizes");
    }
    void add(const float* p, const float* rgb) {
        points->InsertNextPoint(p);
        double bytes[3];
        for (int i = 0; i < 3; ++i) bytes[i] = std::round(255 * std::pow(double(rgb[i]), 1 / 2.2));
        colours->InsertNextTuple(bytes);
    }
    void finish() {
        vtkNew<vtkCellArray> cells; // without, VTK draws nothing
        for (vtkIdType i = 0; i < points->GetNumberOfPoints(); ++i) cells->InsertNextCell(1, &i);
        data->SetVerts(cells);
        data->SetPoints(points);
        data->GetPointData()->SetScalars(colours);
        data->GetPointData()->AddArray(sizes);
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
    if (argc != 16) {
        std::fprintf(stderr, "vtk_spheres_child: 15 arguments, please: see its source\n");
        return 1;
    }
    std::array<double, 13> numbers{}; // eye, target, up, fov, width, height, repeats
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = std::atof(argv[i + 3]);
    const int width = int(numbers[10]);
    const int height = int(numbers[11]);
    const int repeats = int(numbers[12]);

    std::ifstream scene(argv[1], std::ios::binary);
    const auto read = [&](auto& values) {
        scene.read(reinterpret_cast<char*>(values.data()), sizeof values);
    };
    std::array<std::int32_t, 2> counts{};
    read(counts);
    Points spheres;
    std::array<float, 7> sphere{}; // centre, radius, colour
    for (int i = 0; i < counts[0]; ++i) {
        read(sphere);
        spheres.add(sphere.data(), &sphere[4]);
        spheres.sizes->InsertNextValue(sphere[3]);
    }
    spheres.finish();
    Points sticks;
    sticks.sizes->SetNumberOfComponents(3); // length, radius, unused
    vtkNew<vtkFloatArray> axes;
    axes->SetName("axes");
    axes->SetNumberOfComponents(3);
    std::array<float, 10> stick{}; // ends, radius, colour
    for (int i = 0; i < counts[1]; ++i) {
        read(stick);
        std::array<float, 3> middle{};
        std::array<float, 3> axis{};
        for (std::size_t k = 0; k < 3; ++k) {
            middle[k] = (stick[k] + stick[k + 3]) / 2;
            axis[k] = stick[k + 3] - stick[k];
        }
        sticks.add(middle.data(), &stick[7]);
        const std::array size{std::hypot(axis[0], axis[1], axis[2]), stick[6], 0.f};
        for (float& x : axis) x /= size[0]; // VTK multiplies by the length
        axes->InsertNextTypedTuple(axis.data());
        sticks.sizes->InsertNextTypedTuple(size.data());
    }
    sticks.finish();
    sticks.data->GetPointData()->AddArray(axes);

    vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(1, 1, 1);
    const auto add_actor = [&](vtkMapper* mapper) {
        vtkNew<vtkActor> actor;
        actor->SetMapper(mapper);
        vtkProperty* property = actor->GetProperty();
        property->SetAmbient(0.2);
        property->SetDiffuse(0.8);
        property->SetSpecular(0.25);
        property->SetSpecularPower(40);
        renderer->AddActor(actor);
    };
    vtkNew<vtkOpenGLSphereMapper> sphere_mapper;
    sphere_mapper->SetInputData(spheres.data);
    sphere_mapper->SetScaleArray("sizes");
    if (counts[0] > 0) add_actor(sphere_mapper);
    vtkNew<vtkOpenGLStickMapper> stick_mapper;
    stick_mapper->SetInputData(sticks.data);
    stick_mapper->SetScaleArray("sizes");
    stick_mapper->SetOrientationArray("axes");
    if (counts[1] > 0) add_actor(stick_mapper);
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
    draw(0);
    vtkNew<vtkFloatArray> depths;
    window->GetZbufferData(0, 0, width - 1, height - 1, depths);
    std::ofstream mask(argv[2], std::ios::binary);
    mask << "P5\n" << width << ' ' << height << "\n255\n";
    for (int y = height - 1; y >= 0; --y) // VTK's rows begin at the bottom
        for (int x = 0; x < width; ++x)
            mask.put(depths->GetValue(vtkIdType{y} * width + x) < 1 ? '\1' : '\0');
    if (!mask.flush()) {
        std::fprintf(stderr, "vtk_spheres_child: cannot write %s\n", argv[2]);
        return 1;
    }
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) seconds.push_back(draw(i + 1));
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
    std::printf("peer_child: %.6f %s\n", seconds[static_cast<std::size_t>(repeats) / 2],
                renderer_name(window).c_str());
}
