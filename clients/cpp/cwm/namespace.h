// The namespace of everything that <cwm/...> declares. It is inline, so that programs write
// cwm::Sphere, while the linker tells that from what other libraries call cwm::Sphere.
#pragma once

#ifdef CWM_QUALIFIED_NAMES  // for a source that includes such a library: it writes cwm::api::Sphere
#define CWM_API api
#else
#define CWM_API inline api
#endif
