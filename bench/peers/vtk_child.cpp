// VTK's ray caster for GPUs on one field, a program of its own because it needs an X display.
//
// vtk_child FIELD.vti MASK.pgm EYE(3) TARGET(3) UP(3) FOV SIZE REPEATS
// prints "vtk_child: SETUP_SECONDS FRAME_SECONDS RENDERER" as its last line.
// SPDX-License-Identifier: MPL-2.0
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkContourValues.h>
#include <vtkImageData.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPiecewiseFunction.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>
#include <vtkXMLImageDataReader.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

namespace {

/// The words after "OpenGL renderer string:".
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
        std::fprintf(stderr, "vtk_child: 14 arguments, please: see vtk_child.cpp\n");
        return 1;
    }
    std::array<double, 12> numbers{}; // eye, target, up, fov, size, repeats
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = std::atof(argv[i + 3]);
    const int size = int(numbers[10]);
    const int repeats = int(numbers[11]);

    vtkNew<vtkXMLImageDataReader> reader;
    reader->SetFileName(argv[1]);
    reader->Update();

    vtkNew<vtkOpenGLGPUVolumeRayCastMapper> mapper;
    mapper->SetInputConnection(reader->GetOutputPort());
    mapper->SetBlendModeToIsoSurface();
    mapper->AutoAdjustSampleDistancesOff();
    mapper->LockSampleDistanceToInputSpacingOff();
    mapper->SetSampleDistance(float(reader->GetOutput()->GetSpacing()[0]));
    mapper->SetImageSampleDistance(1);
    mapper->UseJitteringOff();

    vtkNew<vtkColorTransferFunction> colour;
    colour->AddRGBPoint(0, 0.8, 0.8, 0.8);
    vtkNew<vtkPiecewiseFunction> opacity;
    opacity->AddPoint(0, 1);
    vtkNew<vtkVolume> volume;
    volume->SetMapper(mapper);
    vtkVolumeProperty* property = volume->GetProperty();
    property->GetIsoSurfaceValues()->SetValue(0, 0);
    property->SetColor(colour);
    property->SetScalarOpacity(opacity);
    property->SetInterpolationTypeToLinear();
    property->ShadeOn();
    property->SetAmbient(0.3); // no covered pixel is black
    property->SetDiffuse(0.7);
    property->SetSpecular(0.2);

    vtkNew<vtkRenderer> renderer;
    renderer->SetBackground(0, 0, 0);
    renderer->AddVolume(volume);
    vtkCamera* camera = renderer->GetActiveCamera();
    camera->SetPosition(&numbers[0]);
    camera->SetFocalPoint(&numbers[3]);
    camera->SetViewUp(&numbers[6]);
    camera->SetViewAngle(numbers[9]);
    renderer->ResetCameraClippingRange();

    vtkNew<vtkRenderWindow> window;
    window->SetOffScreenRendering(1);
    window->SetMultiSamples(0);
    window->SetSize(size, size);
    window->AddRenderer(renderer);

    // Reading the picture waits for it.
    vtkNew<vtkUnsignedCharArray> pixels;
    const auto draw = [&] {
        const auto start = std::chrono::steady_clock::now();
        window->Render();
        window->GetPixelData(0, 0, size - 1, size - 1, 0, pixels);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    const double first = draw();
    std::vector<double> seconds;
    for (int i = 0; i < repeats; ++i) seconds.push_back(draw());
    std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());

    std::ofstream mask(argv[2], std::ios::binary);
    mask << "P5\n" << size << ' ' << size << "\n255\n";
    for (int y = size - 1; y >= 0; --y) { // VTK's rows begin at the bottom
        for (int x = 0; x < size; ++x) {
            const unsigned char* rgb = pixels->GetPointer(3 * (vtkIdType{y} * size + x));
            mask.put(rgb[0] || rgb[1] || rgb[2] ? '\1' : '\0');
        }
    }
    if (!mask.flush()) {
        std::fprintf(stderr, "vtk_child: cannot write %s\n", argv[2]);
        return 1;
    }
    const double frame = seconds[static_cast<std::size_t>(repeats) / 2];
    std::printf("vtk_child: %.6f %.6f %s\n", first - frame, frame, renderer_name(window).c_str());
}
