# baton_find_in_python_package(<out> <package> <path>)
#
# Sets <out> to <path> inside the site-packages folder that holds the installed Python package, and
# <out>_VERSION to the package's version; both are empty if no Python has it. Nothing is imported. The
# project's own environment (.venv) is asked first, then the Python in the PATH.
function(baton_find_in_python_package out package path)
  set(${out} "" PARENT_SCOPE)
  set(${out}_VERSION "" PARENT_SCOPE)
  set(script "from importlib.metadata import distribution as d; p = d('${package}')")
  string(APPEND script "; print(p.version, p.locate_file('${path}'), sep=';')")
  foreach(python IN ITEMS "${CMAKE_SOURCE_DIR}/.venv/bin/python" python3)
    execute_process(
      COMMAND "${python}" -c "${script}"
      OUTPUT_VARIABLE answer
      OUTPUT_STRIP_TRAILING_WHITESPACE
      ERROR_QUIET
      RESULT_VARIABLE status)
    if(status EQUAL 0)
      list(GET answer 0 version)
      list(GET answer 1 found)
      set(${out} "${found}" PARENT_SCOPE)
      set(${out}_VERSION "${version}" PARENT_SCOPE)
      return()
    endif()
  endforeach()
endfunction()
