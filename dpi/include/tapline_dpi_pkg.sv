// The C interface of tapline for SystemVerilog; link the simulation with libtapline_dpi.
package tapline_dpi_pkg;
  import "DPI-C" function chandle tapline_open(input string subject, input string unit, input int plain, input int size);
  import "DPI-C" function void tapline_close(input chandle bench);
  import "DPI-C" function int tapline_inputs(input chandle bench);
  import "DPI-C" function int tapline_outputs(input chandle bench);
  import "DPI-C" function void tapline_set(input chandle bench, input int index, input longint number);
  import "DPI-C" function int tapline_eval(input chandle bench);
  import "DPI-C" function longint tapline_get(input chandle bench, input int index);
  import "DPI-C" function string tapline_error();
  import "DPI-C" function string tapline_version();
endpackage
