// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include "core/base/error.h"
#include "sim/render/context.h"

namespace panoptes::sim {
namespace {

/// EGL's functions, found when they are first asked for: without EGL everything else still runs.
class Egl {
 public:
  static const Egl& get() {
    static const Egl egl;
    return egl;
  }

  decltype(&eglGetProcAddress) get_proc_address;
  decltype(&eglGetError) get_error;
  decltype(&eglInitialize) initialize;
  decltype(&eglQueryString) query_string;
  decltype(&eglBindAPI) bind_api;
  decltype(&eglChooseConfig) choose_config;
  decltype(&eglCreateContext) create_context;
  decltype(&eglDestroyContext) destroy_context;
  decltype(&eglMakeCurrent) make_current;
  PFNEGLGETPLATFORMDISPLAYEXTPROC get_platform_display;
  PFNEGLQUERYDEVICESEXTPROC query_devices;             ///< none: devices are not told
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string;  ///< none: devices are not told

 private:
  Egl() {
    void* library = ::dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
      throw DeviceError("no EGL, so it cannot draw; install the package libegl1 or draw by OSMesa");
    }
    const auto find = [library](auto& function, const char* name) {
      function =
          reinterpret_cast<std::remove_reference_t<decltype(function)>>(::dlsym(library, name));
      if (function == nullptr) {
        throw DeviceError(std::string("libEGL has no ") + name +
                          "; install the package libegl1 again or draw by OSMesa");
      }
    };
    find(get_proc_address, "eglGetProcAddress");
    find(get_error, "eglGetError");
    find(initialize, "eglInitialize");
    find(query_string, "eglQueryString");
    find(bind_api, "eglBindAPI");
    find(choose_config, "eglChooseConfig");
    find(create_context, "eglCreateContext");
    find(destroy_context, "eglDestroyContext");
    find(make_current, "eglMakeCurrent");
    const auto find_extension = [this](auto& function, const char* name) {
      function =
          reinterpret_cast<std::remove_reference_t<decltype(function)>>(get_proc_address(name));
    };
    find_extension(get_platform_display, "eglGetPlatformDisplayEXT");
    find_extension(query_devices, "eglQueryDevicesEXT");
    find_extension(query_device_string, "eglQueryDeviceStringEXT");
  }
};

bool has_word(const char* words, std::string_view word) {
  const std::string_view all = words == nullptr ? "" : words;
  for (std::size_t at = all.find(word); at != std::string_view::npos; at = all.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if ((at == 0 || all[at - 1] == ' ') && (end == all.size() || all[end] == ' ')) {
      return true;
    }
  }
  return false;
}

/// Where drawing may be tried, best first.
std::vector<EGLDisplay> displays(const Egl& egl, bool software) {
  std::vector<EGLDisplay> cards;
  std::vector<EGLDisplay> others;
  if (egl.get_platform_display == nullptr) {
    return {};
  }
  if (egl.query_devices != nullptr && egl.query_device_string != nullptr) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (egl.query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count) ==
        EGL_TRUE) {
      for (EGLint i = 0; i < count; ++i) {
        EGLDeviceEXT device = devices[static_cast<std::size_t>(i)];
        const bool is_software =
            has_word(egl.query_device_string(device, EGL_EXTENSIONS), "EGL_MESA_device_software");
        (is_software ? others : cards)
            .push_back(egl.get_platform_display(EGL_PLATFORM_DEVICE_EXT, device, nullptr));
      }
    }
  }
  others.push_back(egl.get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
  if (software) {
    return others;
  }
  cards.insert(cards.end(), others.begin(), others.end());
  return cards;
}

class EglContext final : public GlContext {
 public:
  explicit EglContext(bool software) : egl_(Egl::get()) {
    for (EGLDisplay display : displays(egl_, software)) {
      if (display != EGL_NO_DISPLAY && create_on(display)) {
        return;
      }
    }
    throw DeviceError(
        "no OpenGL 4.5 from EGL, so it cannot draw; install the package libegl-mesa0, unset "
        "GALLIUM_DRIVER and MESA_GL_VERSION_OVERRIDE, or draw by OSMesa");
  }
  ~EglContext() override {
    forget();
    egl_.destroy_context(display_, context_);
  }
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  Function function(const char* name) const override { return egl_.get_proc_address(name); }
  const char* name() const override { return "EGL"; }

 private:
  bool create_on(EGLDisplay display) {
    // Initialising again does nothing; other renderers of this process may use the display still,
    // so it is never terminated.
    if (egl_.initialize(display, nullptr, nullptr) == EGL_FALSE ||
        egl_.bind_api(EGL_OPENGL_API) == EGL_FALSE) {
      return false;
    }
    const char* extensions = egl_.query_string(display, EGL_EXTENSIONS);
    EGLConfig config = nullptr;
    if (!has_word(extensions, "EGL_KHR_surfaceless_context")) {
      return false;
    }
    if (!has_word(extensions, "EGL_KHR_no_config_context")) {
      const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_DONT_CARE, EGL_RENDERABLE_TYPE,
                                         EGL_OPENGL_BIT, EGL_NONE};
      EGLint count = 0;
      if (egl_.choose_config(display, wanted.data(), &config, 1, &count) == EGL_FALSE ||
          count == 0) {
        return false;
      }
    }
    const std::array<EGLint, 7> wanted{EGL_CONTEXT_MAJOR_VERSION,
                                       4,
                                       EGL_CONTEXT_MINOR_VERSION,
                                       5,
                                       EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                       EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                       EGL_NONE};
    context_ = egl_.create_context(display, config, EGL_NO_CONTEXT, wanted.data());
    display_ = display;
    return context_ != EGL_NO_CONTEXT;
  }

  void bind() override {
    egl_.bind_api(EGL_OPENGL_API);
    if (egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      throw DeviceError("EGL's context cannot be used in this thread; draw from one thread only");
    }
  }
  void release() override {
    egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }

  const Egl& egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context(bool software) {
  return std::make_unique<EglContext>(software);
}

}  // namespace panoptes::sim
