# The Debian packages, one for each component of install.cmake, manuals.cmake and the clients.
install(FILES packaging/cwm-server.service DESTINATION lib/systemd/system COMPONENT server)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME cwm)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each component has its own
# Debian requires a maintainer. The default says that the packages have none yet.
set(CWM_MAINTAINER "Nobody yet (built locally) <nobody@cwm.invalid>" CACHE STRING
    "who answers for the Debian packages: NAME <ADDRESS>")
set(CPACK_PACKAGE_CONTACT "${CWM_MAINTAINER}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/packaging/stage.cmake)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
    GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# Components and their packages, in the same order.
set(CPACK_COMPONENTS_ALL server cli client-dev python)
set(CPACK_CWM_PACKAGES cwm-server cwm-cli libcwm-dev python3-cwm)

set(scripts ${PROJECT_SOURCE_DIR}/packaging/server)
set(CPACK_DEBIAN_SERVER_PACKAGE_NAME cwm-server)
set(CPACK_DEBIAN_SERVER_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_SERVER_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS "adduser, init-system-helpers (>= 1.52)")
set(CPACK_DEBIAN_SERVER_PACKAGE_SUGGESTS cwm-cli)
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
    ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm ${scripts}/conffiles)
set(CPACK_COMPONENT_SERVER_DESCRIPTION
    "collision world model server
Turns point clouds into shapes, keeps them as a world with revisions, and
answers over gRPC: distances, contacts, collisions of bodies and robots.
It runs as its own user and listens at unix:/run/cwm/cwm.sock.")

set(CPACK_DEBIAN_CLI_PACKAGE_NAME cwm-cli)
set(CPACK_DEBIAN_CLI_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_CLI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_CLI_PACKAGE_SUGGESTS cwm-server)
set(CPACK_COMPONENT_CLI_DESCRIPTION
    "command line of the collision world model
cwm feeds and asks a server, cwm-plan plans motions, cwm-grasp finds grasps,
cwm-simulator makes scans of scenes whose truth is known.")

set(CPACK_DEBIAN_CLIENT-DEV_PACKAGE_NAME libcwm-dev)
set(CPACK_DEBIAN_CLIENT-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_CLIENT-DEV_PACKAGE_DEPENDS
    "libabsl-dev, libeigen3-dev, libgrpc++-dev, libprotobuf-dev, libssl-dev, libtinyxml2-dev, libyaml-cpp-dev")
set(CPACK_COMPONENT_CLIENT-DEV_DESCRIPTION
    "C++ client of the collision world model
Headers, static libraries and the CMake package cwm for programs that ask a
server.")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-cwm)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.11), python3-grpcio, python3-numpy, python3-protobuf")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION
    "Python client of the collision world model
Scans, objects, distances and motions as numpy arrays and dataclasses.")
include(CPack)
