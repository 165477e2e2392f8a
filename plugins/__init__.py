"""Where cadlink and solver meet the user's tools: command line, scene files, VTK files, pictures, reports."""
